//! A curve at many parameters.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::{
    faults::Faults,
    json::{members::of_request, request::request, writer::whole_of},
    problem::Problem,
    shapes::places::{Values, out_of_range, within},
    warning::WarningBody,
};
use flankfit_engine::{
    geometry::{
        contract::Point,
        curve::{
            Curve, CurveShape,
            measure::{self, Bending},
        },
    },
    numerics::cancel,
    words::rounded,
};

/// Most parameters at which the arc length is asked for.
const MOST_LENGTHS: usize = 10_000;

request! {
    /// A curve and the parameters at which it is evaluated.
    #[schema(as = EvaluateCurve)]
    pub struct EvaluateCurveBody as EvaluateCurveMembers {
        required curve: CurveShape,
        /// Parameters within the curve's domain, in any order.
        required at: Vec<f64>,
        /// Highest order of the returned derivatives. Default 0.
        #[schema(minimum = 0, maximum = 3)]
        optional derivatives: usize,
        /// Parts that are returned only when requested.
        optional include: Vec<CurveIncludeName>,
    }
}

/// Optional parts of the result: `arc_length` for at most 10,000 parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = CurveInclude)]
pub enum CurveIncludeName {
    ArcLength,
}

/// A curve at parameters, in the order of `at`.
#[skip_serializing_none]
#[derive(Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = CurveValues)]
pub struct CurveValuesBody {
    /// Points of the curve; numbers for a graph.
    #[schema(value_type = Vec<Point>)]
    pub values: Values,
    /// By order: first derivatives, second ones, …
    #[schema(value_type = Option<Vec<Vec<Point>>>)]
    pub derivatives: Option<Vec<Values>>,
    /// With two derivatives or more: 1/radius; for plane curves and graphs > 0 where the curve
    /// turns left. Absent, with a warning, where the first derivative is 0 at one of the
    /// parameters.
    #[schema(value_type = Option<Vec<f64>>)]
    pub curvature: Option<Values>,
    /// With three derivatives: torsion of a space curve; absent where its curvature is 0 at one of
    /// the parameters.
    #[schema(value_type = Option<Vec<f64>>)]
    pub torsion: Option<Values>,
    /// Length from the start of the domain to each parameter; for a graph that of the line (x,
    /// y(x)).
    #[schema(value_type = Option<Vec<f64>>)]
    pub arc_length: Option<Values>,
    /// Length of the whole curve.
    pub length: Option<f64>,
    /// Estimated error of the lengths.
    pub length_error: Option<f64>,
    /// Warnings about the result.
    pub warnings: Vec<WarningBody>,
}

/// A request, read and checked.
struct CheckedRequest {
    curve: CurveShape,
    at: Vec<f64>,
    derivatives: usize,
    arc_length: bool,
}

/// Answers a request. Processor work.
pub fn answer(text: &[u8]) -> Result<Vec<u8>, Problem> {
    let CheckedRequest { curve, at, derivatives, arc_length } = read(text)?;
    let width = curve.dimension().count();
    let mut orders = vec![Vec::with_capacity(at.len() * width); derivatives + 1];
    let mut bends = Bends::default();
    for (index, t) in at.iter().enumerate() {
        cancel::checkpoint();
        if derivatives == 0 {
            orders[0].extend_from_slice(&curve.value(*t).as_slice()[..width]);
            continue;
        }
        let jet = curve.jet(*t);
        for (order, flat) in orders.iter_mut().enumerate() {
            flat.extend_from_slice(&jet[order].as_slice()[..width]);
        }
        if derivatives >= 2 {
            bends.add(index, measure::bending(&curve, *t));
        }
    }
    let mut warnings = Vec::new();
    let lengths = match arc_length {
        true => Some(Lengths::of(&curve, &at).ok_or_else(|| out_of_range("/at"))?),
        false => None,
    };
    if let Some(lengths) = lengths.as_ref().filter(|lengths| !lengths.converged) {
        let message = format!(
            "the lengths are accurate to {} only: the curve is small or irregular relative to its coordinates",
            rounded(lengths.error, 2)
        );
        warnings.push(WarningBody::new("length_uncertain", message));
    }
    warnings.extend(bends.still.map(|(first, count)| {
        let message = format!(
            "the first derivative is 0 at {count} of the parameters, first at number {first}: there is no curvature \
             there"
        );
        WarningBody::new("no_curvature", message)
    }));
    let has_curvature = derivatives >= 2 && bends.still.is_none();
    let mut orders = orders.into_iter().map(|flat| Values { width, flat });
    let body = CurveValuesBody {
        values: orders.next().unwrap_or_else(|| Vec::new().into()),
        derivatives: (derivatives > 0).then(|| orders.collect()),
        curvature: has_curvature.then(|| bends.curvature.into()),
        torsion: (has_curvature && derivatives == 3 && bends.has_torsion).then(|| bends.torsion.into()),
        length: lengths.as_ref().map(|lengths| lengths.whole),
        length_error: lengths.as_ref().map(|lengths| lengths.error),
        arc_length: lengths.map(|lengths| lengths.from_start.into()),
        warnings,
    };
    whole_of(256 + 22 * at.len() * (width * (derivatives + 1) + 1), &body).map_err(|_| out_of_range("/at"))
}

/// Curvatures and torsions, place by place.
struct Bends {
    curvature: Vec<f64>,
    torsion: Vec<f64>,
    /// Whether every place so far has a torsion.
    has_torsion: bool,
    /// The first place with zero derivative, and the number of such places.
    still: Option<(usize, usize)>,
}

impl Default for Bends {
    fn default() -> Self {
        Bends { curvature: Vec::new(), torsion: Vec::new(), has_torsion: true, still: None }
    }
}

impl Bends {
    fn add(&mut self, index: usize, bending: Bending) {
        match bending.curvature {
            Some(curvature) => self.curvature.push(curvature),
            None => {
                let (first, count) = self.still.unwrap_or((index, 0));
                self.still = Some((first, count + 1));
            }
        }
        self.has_torsion &= bending.torsion.is_some();
        self.torsion.extend(bending.torsion);
    }
}

/// Lengths from the start of the domain.
struct Lengths {
    from_start: Vec<f64>,
    whole: f64,
    error: f64,
    /// Whether the error is what was aimed at.
    converged: bool,
}

impl Lengths {
    /// `None` where they leave the range of doubles.
    fn of(curve: &CurveShape, at: &[f64]) -> Option<Self> {
        let (each, whole) = measure::arc_lengths(curve, at, measure::DEFAULT_TOLERANCE).ok()?;
        let from_start = each.iter().map(|length| length.length).collect();
        Some(Lengths { from_start, whole: whole.length, error: whole.error, converged: whole.converged })
    }
}

fn read(text: &[u8]) -> Result<CheckedRequest, Problem> {
    let mut faults = Faults::default();
    let members: EvaluateCurveMembers<'_> = of_request(text, &mut faults)?;
    let curve = members.curve.required(&mut faults);
    let at = members.at.numbers(&mut faults);
    let derivatives = members.derivatives.read(&mut faults).unwrap_or(0);
    let include = members.include.read(&mut faults).unwrap_or_default();
    let arc_length = include.contains(&CurveIncludeName::ArcLength);
    if let (Some(curve), Some(at)) = (&curve, &at) {
        within(at.iter().copied().enumerate(), curve.domain(), |i| format!("/at/{i}"), &mut faults);
        if arc_length && at.len() > MOST_LENGTHS {
            faults.push(
                "/at",
                format!("arc lengths are available for at most {MOST_LENGTHS} parameters, not {}", at.len()),
            );
        }
    }
    let (Some(curve), Some(at)) = (curve, at) else { return Err(Problem::invalid(faults)) };
    faults.into_result(CheckedRequest { curve, at, derivatives, arc_length }).map_err(Problem::invalid)
}
