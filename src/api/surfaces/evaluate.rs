//! A surface at many parameters.

use super::values::{
    AreaBody, CurvaturesBody, EvaluateSurfaceMembers, FundamentalFormsBody, ParameterGridMembers,
    SurfaceDerivativesBody, SurfaceIncludeName, SurfaceValuesBody,
};
use crate::api::{
    faults::Faults,
    json::{
        members::{of_object, of_request},
        numbers::read_rows,
        writer::whole_of,
    },
    problem::{Problem, Room},
    shapes::places::{Values, out_of_range, within},
    warning::WarningBody,
};
use flankfit_engine::{
    geometry::surface::{Evaluator, LocalGeometry, Surface, SurfaceJet, SurfaceShape, area},
    numerics::cancel::Asking,
    words::{counted, rounded},
};

/// Relative error to which areas are computed.
const AREA_TOLERANCE: f64 = 1e-10;
/// Most numbers of an answer, some 400 megabytes of text.
const MOST_NUMBERS: usize = 20_000_000;

/// A number in the text of an answer, with its comma.
const TEXT_OF_NUMBER: usize = 24;
/// Bytes of a place during its evaluation: the surface with its derivatives there.
const EACH: usize = size_of::<SurfaceJet>();

/// A request, read and checked.
struct CheckedRequest {
    surface: SurfaceShape,
    parameters: Parameters,
    derivatives: usize,
    forms: bool,
    area: bool,
}

enum Parameters {
    Pairs(Vec<[f64; 2]>),
    Grid(Vec<f64>, Vec<f64>),
}

impl Parameters {
    fn count(&self) -> usize {
        match self {
            Parameters::Pairs(pairs) => pairs.len(),
            Parameters::Grid(u, v) => u.len().saturating_mul(v.len()),
        }
    }

    fn pairs(&self) -> Box<dyn Iterator<Item = (f64, f64)> + '_> {
        match self {
            Parameters::Pairs(pairs) => Box::new(pairs.iter().map(|[u, v]| (*u, *v))),
            Parameters::Grid(u, v) => Box::new(u.iter().flat_map(move |u| v.iter().map(move |v| (*u, *v)))),
        }
    }

    /// Values end to end.
    fn values(&self, evaluator: &Evaluator, width: usize) -> Vec<f64> {
        if width == 1 {
            return match self {
                Parameters::Pairs(pairs) => evaluator.heights(pairs),
                Parameters::Grid(u, v) => evaluator.grid_heights(u, v),
            };
        }
        let values = match self {
            Parameters::Pairs(pairs) => evaluator.values(pairs),
            Parameters::Grid(u, v) => evaluator.grid_values(u, v),
        };
        values.iter().flat_map(|value| value.as_slice()[..width].iter().copied()).collect()
    }

    fn jets(&self, evaluator: &Evaluator) -> Vec<SurfaceJet> {
        match self {
            Parameters::Pairs(pairs) => evaluator.jets(pairs),
            Parameters::Grid(u, v) => evaluator.grid_jets(u, v),
        }
    }
}

/// Answers a request, as far as there is `room`: two axes may ask for the grid of all their pairs.
/// Processor work.
pub fn answer(text: &[u8], room: Room) -> Result<Vec<u8>, Problem> {
    let CheckedRequest { surface, parameters, derivatives, forms, area: wants_area } = read(text)?;
    let width = surface.dimension().count();
    let count = parameters.count();
    let numbers = count * numbers_at_each(width, derivatives, forms);
    room(256 + numbers * (TEXT_OF_NUMBER + size_of::<f64>()) + count * EACH)?;
    let evaluator = Evaluator::new(&surface);
    let mut geometry = Geometry::default();
    let mut lists: [Vec<f64>; 6] = Default::default();
    if derivatives == 0 && !forms {
        lists[0] = parameters.values(&evaluator, width);
    } else {
        for list in &mut lists[..[1, 3, 6][derivatives]] {
            list.reserve_exact(count * width);
        }
        for (index, (jet, (u, v))) in
            parameters.jets(&evaluator).into_iter().zip(parameters.pairs()).enumerate().asking(200)
        {
            let place = jet.placed(surface.dimension(), u, v);
            geometry.add(index, &LocalGeometry::of(&surface, &place, u, v));
            let all = [jet.value, jet.u, jet.v, jet.uu, jet.uv, jet.vv];
            for (list, value) in lists.iter_mut().zip(all).take([1, 3, 6][derivatives]) {
                list.extend_from_slice(&value.as_slice()[..width]);
            }
        }
    }
    let mut warnings = Vec::new();
    let area = wants_area.then(|| area::area(&surface, AREA_TOLERANCE));
    if let Some(area) = area.as_ref().filter(|area| !area.converged) {
        let message = format!("the area is accurate to {} only", rounded(area.error_estimate, 2));
        warnings.push(WarningBody::new("area_uncertain", message));
    }
    if let Some((first, count)) = geometry.singular {
        let left_out =
            if geometry.has_normals { "curvatures and forms are" } else { "normals, curvatures and forms are" };
        let message = format!(
            "the surface has no curvature at {count} of the places, first at number {first}: {left_out} omitted"
        );
        warnings.push(WarningBody::new("no_tangent_plane", message));
    }
    let Geometry { normals, has_normals, gaussian, mean, principal, direction, first, second, singular } = geometry;
    let [values, u, v, uu, uv, vv] = lists.map(|flat| Values { width, flat });
    let second_order = |values| Some(values).filter(|_| derivatives > 1);
    let body = SurfaceValuesBody {
        values,
        derivatives: (derivatives > 0).then(|| SurfaceDerivativesBody {
            u,
            v,
            uu: second_order(uu),
            uv: second_order(uv),
            vv: second_order(vv),
        }),
        normals: (has_normals && derivatives > 0).then_some(Values { width: 3, flat: normals }),
        curvatures: (singular.is_none() && derivatives > 1).then(|| CurvaturesBody {
            gaussian: gaussian.into(),
            mean: mean.into(),
            principal: Values { width: 2, flat: principal },
            direction: Values { width: 3, flat: direction },
        }),
        fundamental_forms: (singular.is_none() && forms).then_some(FundamentalFormsBody {
            first: Values { width: 3, flat: first },
            second: Values { width: 3, flat: second },
        }),
        area: area.map(|area| AreaBody { value: area.area, error: area.error_estimate }),
        warnings,
    };
    whole_of(256 + TEXT_OF_NUMBER * numbers, &body).map_err(|_| out_of_range("/surface"))
}

/// Values, derivatives, normal, curvatures and forms.
fn numbers_at_each(width: usize, derivatives: usize, forms: bool) -> usize {
    width * [1, 3, 6][derivatives] + [0, 3, 10][derivatives] + if forms { 6 } else { 0 }
}

/// Geometry from the derivatives, place by place.
struct Geometry {
    normals: Vec<f64>,
    /// Whether every place so far has one.
    has_normals: bool,
    gaussian: Vec<f64>,
    mean: Vec<f64>,
    principal: Vec<f64>,
    direction: Vec<f64>,
    first: Vec<f64>,
    second: Vec<f64>,
    /// The first place without curvatures, and how many there are.
    singular: Option<(usize, usize)>,
}

impl Default for Geometry {
    fn default() -> Self {
        let (normals, gaussian, mean, principal, direction, first, second) = Default::default();
        Geometry { normals, has_normals: true, gaussian, mean, principal, direction, first, second, singular: None }
    }
}

impl Geometry {
    fn add(&mut self, index: usize, local: &LocalGeometry) {
        self.has_normals &= local.normal.is_some();
        self.normals.extend(local.normal.iter().flatten());
        let Some(curvature) = &local.differential else {
            let (first, count) = self.singular.unwrap_or((index, 0));
            self.singular = Some((first, count + 1));
            return;
        };
        self.gaussian.push(curvature.gaussian);
        self.mean.push(curvature.mean);
        self.principal.extend(curvature.principal);
        self.direction.extend(curvature.directions[0].iter());
        self.first.extend(curvature.first_form);
        self.second.extend(curvature.second_form);
    }
}

fn read(text: &[u8]) -> Result<CheckedRequest, Problem> {
    let mut faults = Faults::default();
    let members: EvaluateSurfaceMembers<'_> = of_request(text, &mut faults)?;
    let surface = members.surface.required(&mut faults);
    let parameters = read_parameters(&members, &mut faults);
    let derivatives = members.derivatives.read(&mut faults).unwrap_or(0);
    let include = members.include.read(&mut faults).unwrap_or_default();
    if let (Some(surface), Some(parameters)) = (&surface, &parameters) {
        let [domain_u, domain_v] = surface.domain();
        match parameters {
            Parameters::Pairs(pairs) => {
                let axis = |axis: usize| pairs.iter().map(move |pair| pair[axis]).enumerate();
                within(axis(0), domain_u, |i| format!("/at/{i}/0"), &mut faults);
                within(axis(1), domain_v, |i| format!("/at/{i}/1"), &mut faults);
            }
            Parameters::Grid(u, v) => {
                within(u.iter().copied().enumerate(), domain_u, |i| format!("/grid/u/{i}"), &mut faults);
                within(v.iter().copied().enumerate(), domain_v, |i| format!("/grid/v/{i}"), &mut faults);
            }
        }
    }
    let (Some(surface), Some(parameters)) = (surface, parameters) else { return Err(Problem::invalid(faults)) };
    let forms = include.contains(&SurfaceIncludeName::FundamentalForms);
    let numbers = parameters.count().saturating_mul(numbers_at_each(surface.dimension().count(), derivatives, forms));
    if numbers > MOST_NUMBERS {
        let at = if matches!(parameters, Parameters::Pairs(_)) { "/at" } else { "/grid" };
        faults.push(
            at,
            format!(
                "the response would have {numbers} numbers, at most {MOST_NUMBERS} are allowed: send fewer places \
                at a time"
            ),
        );
    }
    let area = include.contains(&SurfaceIncludeName::Area);
    faults.into_result(CheckedRequest { surface, parameters, derivatives, forms, area }).map_err(Problem::invalid)
}

fn read_parameters(members: &EvaluateSurfaceMembers<'_>, faults: &mut Faults) -> Option<Parameters> {
    match (members.at.text(), members.grid.text()) {
        (Some(slice), None) => {
            let (flat, lengths) = read_rows(slice, "/at", faults)?;
            let before = faults.count();
            for (i, length) in lengths.iter().enumerate().filter(|(_, length)| **length != 2) {
                faults.push(
                    format!("/at/{i}"),
                    format!("{}, where a pair [u, v] is needed", counted(*length, "number", "numbers")),
                );
            }
            (faults.count() == before)
                .then(|| Parameters::Pairs(flat.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect()))
        }
        (None, Some(slice)) => {
            let grid: ParameterGridMembers<'_> = of_object(slice, "/grid", faults)?;
            let (u, v) = (grid.u.numbers(faults), grid.v.numbers(faults));
            let parameters = Parameters::Grid(u?, v?);
            Some(parameters)
        }
        (None, None) => {
            faults.push_missing("/at", "missing; give `at` or `grid`");
            None
        }
        (Some(_), Some(_)) => {
            faults.push("/grid", "give either `at` or `grid`, not both");
            None
        }
    }
}
