//! Reads the request of a randomisation study, and makes the matrix of its nodes.

use serde::Deserialize;

use super::request::StudyScaling;
use crate::api::{
    faults::{Faults, Field},
    fits::reader,
    json::{error::ReadError, extra::NoExtra, part::read_json, present::present, slice::Slice},
    problem::Problem,
};
use flankfit_engine::estimation::randomization::{ColumnScaling, Measured, Setup, Study, StudyField};

/// As it is read: nodes and model go through the reader of fit requests.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawRequest<'a> {
    #[serde(default, deserialize_with = "present")]
    x: Option<Vec<Vec<f64>>>,
    #[serde(borrow, default, deserialize_with = "present")]
    nodes: Option<Slice<'a>>,
    #[serde(borrow, default, deserialize_with = "present")]
    model: Option<Slice<'a>>,
    #[serde(borrow, default, deserialize_with = "present")]
    domain: Option<Slice<'a>>,
    #[serde(default, deserialize_with = "present")]
    coefficients: Option<Vec<f64>>,
    #[serde(default, deserialize_with = "present")]
    noise_sigma: Option<f64>,
    levels: Vec<f64>,
    repetitions: usize,
    #[serde(default, deserialize_with = "present")]
    seed: Option<u64>,
    #[serde(default, deserialize_with = "present")]
    scaling: Option<StudyScaling>,
}

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

/// What is studied, from either form.
struct Material {
    x: Vec<Vec<f64>>,
    terms: Vec<String>,
    /// What nodes suggest.
    coefficients: Option<Vec<f64>>,
    sigma: Option<f64>,
}

/// Reads a request. Processor work where it has nodes.
pub fn read(text: &[u8]) -> Result<CheckedStudy, Problem> {
    let mut raw: RawRequest<'_> = read_json(text)?;
    let from_nodes = raw.nodes.is_some();
    let material = match (raw.x.take(), raw.nodes) {
        (Some(_), Some(_)) => return refused("/nodes", "give either `x` or `nodes`, not both"),
        (None, None) => return refused("/x", "missing; give `x`, or `nodes` with `model`"),
        (Some(x), None) => {
            for (part, name) in [(&raw.model, "model"), (&raw.domain, "domain")] {
                if part.is_some() {
                    return refused(&format!("/{name}"), "it belongs to `nodes`");
                }
            }
            let terms = (0..x.first().map_or(0, Vec::len)).map(|j| format!("x{j}")).collect();
            Material { x, terms, coefficients: None, sigma: None }
        }
        (None, Some(nodes)) => measured(nodes, raw.model, raw.domain)?,
    };
    let (coefficients_given, noise_sigma_given) = (raw.coefficients.is_some(), raw.noise_sigma.is_some());
    let Some(coefficients) = raw.coefficients.or(material.coefficients) else {
        return refused("/coefficients", "missing; a bare matrix has no heights to assume them from");
    };
    let Some(noise_sigma) = raw.noise_sigma.or(material.sigma) else {
        return refused("/noise_sigma", "missing, and there are no residuals to assume it from");
    };
    let (repetitions, seed) = (raw.repetitions, raw.seed.unwrap_or(0));
    let scaling = raw.scaling.unwrap_or(StudyScaling::None);
    let rows = material.x.len();
    let study = Study::new(Setup {
        x: material.x,
        coefficients: coefficients.clone(),
        noise_sigma,
        levels: raw.levels,
        repetitions,
        seed,
        scaling: match scaling {
            StudyScaling::None => ColumnScaling::None,
            StudyScaling::UnitLength => ColumnScaling::UnitLength,
        },
    })
    .map_err(|found| {
        // the matrix was made from the nodes, as were coefficients that are not given
        let made = |field: &StudyField| match field {
            StudyField::Matrix | StudyField::Row(_) => from_nodes,
            StudyField::Coefficients | StudyField::Coefficient(_) => from_nodes && !coefficients_given,
            _ => false,
        };
        Problem::invalid(Faults::by(&found, |field| if made(field) { "/nodes".to_owned() } else { field.pointer() }))
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

fn measured(nodes: Slice, model: Option<Slice>, domain: Option<Slice>) -> Result<Material, Problem> {
    let mut text = [b"{\"nodes\":", nodes.0].concat();
    for (name, part) in [("model", model), ("domain", domain)] {
        if let Some(Slice(part)) = part {
            text.extend_from_slice(format!(",\"{name}\":").as_bytes());
            text.extend_from_slice(part);
        }
    }
    text.push(b'}');
    let (nodes, spec, NoExtra {}) = reader::read_fit(&text).map_err(|error: ReadError| Problem::from(error))?;
    let measured = Measured::new(&nodes, &spec)?;
    Ok(Material {
        x: measured.x,
        terms: measured.labels,
        coefficients: Some(measured.coefficients),
        sigma: measured.sigma,
    })
}
