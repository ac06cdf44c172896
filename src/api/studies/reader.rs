//! Reads the request of a randomisation study, and makes the matrix of its nodes.

use super::request::{RandomizationMembers, StudyScaling};
use crate::api::{
    faults::{Faults, is_within, pointer_of},
    fits::{
        reader::{nodes::RawNodes, spec},
        spec::request::FitSpecMembers,
    },
    json::{
        members::{Members, of_request},
        numbers::read_rows,
    },
    problem::Problem,
};
use flankfit_engine::{
    estimation::randomization::{ColumnScaling, Measured, Setup, Study},
    numerics::{Rows, cancel, check},
};

/// A request read and checked.
pub struct CheckedStudy {
    pub study: Study,
    pub terms: Vec<String>,
    pub coefficients: Vec<f64>,
    pub coefficients_given: bool,
    pub noise_sigma: f64,
    pub noise_sigma_given: bool,
    pub repetitions: usize,
    pub seed: u64,
    pub scaling: StudyScaling,
    pub rows: usize,
}

/// Matrix and truth of the study, from either form.
struct Material {
    x: Rows,
    terms: Vec<String>,
    /// Coefficients estimated from nodes.
    coefficients: Option<Vec<f64>>,
    sigma: Option<f64>,
}

/// Reads a request. Processor work where it has nodes.
pub fn read(text: &[u8]) -> Result<CheckedStudy, Problem> {
    read_by(text, Study::new)
}

/// The same for a study whose repetitions are computed in parts.
pub fn read_in_parts(text: &[u8]) -> Result<CheckedStudy, Problem> {
    read_by(text, Study::in_parts)
}

fn read_by(text: &[u8], make: fn(Setup) -> Result<Study, check::Faults>) -> Result<CheckedStudy, Problem> {
    let mut faults = Faults::default();
    let members: RandomizationMembers<'_> = of_request(text, &mut faults)?;
    let x = members.x.optional_with(&mut faults, read_rows);
    let coefficients = members.coefficients.read(&mut faults);
    let noise_sigma = members.noise_sigma.read(&mut faults);
    let levels = members.levels.required(&mut faults);
    let repetitions = members.repetitions.required(&mut faults);
    let (seed, scaling) = (members.seed.read(&mut faults), members.scaling.read(&mut faults));
    let (Some(levels), Some(repetitions)) = (levels, repetitions) else { return Err(Problem::invalid(faults)) };
    faults.into_result(()).map_err(Problem::invalid)?;
    let from_nodes = members.nodes.is_some();
    let material = match (x, members.nodes) {
        (Some(_), Some(_)) => return refused("/nodes", "give either `x` or `nodes`, not both"),
        (None, None) => return refused("/x", "missing; give `x`, or `nodes` with `model`"),
        (Some((values, lengths)), None) => {
            let strangers = [members.model.name_if_given(), members.domain.name_if_given()];
            if let Some(name) = strangers.into_iter().flatten().next() {
                return refused(&format!("/{name}"), "it belongs to `nodes`");
            }
            let terms = (0..lengths.first().copied().unwrap_or(0)).map(|j| format!("x{j}")).collect();
            Material { x: Rows::new(values, lengths), terms, coefficients: None, sigma: None }
        }
        (None, Some(nodes)) => {
            let (model, domain) = (members.model, members.domain);
            measured(nodes, &FitSpecMembers { model, domain, ..FitSpecMembers::at("") })?
        }
    };
    let (coefficients_given, noise_sigma_given) = (coefficients.is_some(), noise_sigma.is_some());
    let Some(coefficients) = coefficients.or(material.coefficients) else {
        return refused("/coefficients", "missing; without nodes they cannot be estimated");
    };
    let Some(noise_sigma) = noise_sigma.or(material.sigma) else {
        return refused("/noise_sigma", "missing; without residuals it cannot be estimated");
    };
    let seed = seed.unwrap_or(0);
    let scaling = scaling.unwrap_or(StudyScaling::None);
    let rows = material.x.count();
    let study = make(Setup {
        x: material.x,
        coefficients: coefficients.clone(),
        noise_sigma,
        levels,
        repetitions,
        seed,
        scaling: match scaling {
            StudyScaling::None => ColumnScaling::None,
            StudyScaling::UnitLength => ColumnScaling::UnitLength,
        },
    })
    .map_err(|found| {
        // the matrix was made from the nodes, as were coefficients that are not given
        let lists: &[&str] = if coefficients_given { &["x"] } else { &["x", "coefficients"] };
        let made = |path: &str| from_nodes && is_within(path, lists);
        Problem::invalid(Faults::placed(&found, |path| if made(path) { "/nodes".to_owned() } else { pointer_of(path) }))
    })?;
    Ok(CheckedStudy {
        study,
        terms: material.terms,
        coefficients,
        coefficients_given,
        noise_sigma,
        noise_sigma_given,
        repetitions,
        seed,
        scaling,
        rows,
    })
}

fn refused<T>(pointer: &str, detail: &str) -> Result<T, Problem> {
    Err(Problem::invalid(Faults::one(pointer, detail)))
}

fn measured(nodes: RawNodes<'_>, spec: &FitSpecMembers<'_>) -> Result<Material, Problem> {
    let mut faults = Faults::default();
    let nodes = RawNodes::required(Some(nodes), &mut faults);
    let spec = spec::read(spec, &mut faults);
    let (Some(nodes), Some(spec)) = (nodes, spec) else { return Err(Problem::invalid(faults)) };
    faults.into_result(()).map_err(Problem::invalid)?;
    let measured = cancel::uncounted(|| Measured::new(&nodes, &spec))?;
    Ok(Material {
        x: measured.x,
        terms: measured.labels,
        coefficients: Some(measured.coefficients),
        sigma: measured.sigma,
    })
}
