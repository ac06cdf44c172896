//! Figures of the flank that an iteration's fit is of: slopes, crownings and twist from the fit's
//! own coefficients, held against what the job requires.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{
    evaluation::figures::FigureBody,
    gear::of_text,
    notice::NoticeBody,
    requirements::{RequirementsBody, class_left_aside},
};
use crate::{
    api::{json::writer, measurand::axes::AxesBody},
    jobs::{Job, Measurand},
};
use flankfit_engine::{
    estimation::{
        FitSpec, Nodes,
        result::WeightedSum,
        spec::{Degree, Model, Terms},
    },
    gear::{
        Gear, ProfileAxis, Side,
        evaluation::{ToleranceLimits, flank_surface::FittedFlank},
    },
};

/// Slopes, crownings and twist of the fitted surface, in µm over what the nodes span: of the
/// surface of second order that is nearest to it in the mean square, with the signs of ISO 1328-1
/// and DIN's for slopes. Heights of nodes are along the normal of the flank; figures are
/// transverse, as tolerances and evaluations are: greater by 1/cos β_b. Limits of slopes are over
/// the whole profile and the whole face width: what the nodes span is taken for the whole of the
/// profile, and of the width they have their share. They are by the gear and the requirements that
/// the job had when the fit was made. What cannot be told is left out, and `warnings` say why.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = FitFigures)]
pub struct FitFiguresBody {
    /// From root to tip; positive where material grows towards the tip.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile_slope_um: Option<FigureBody>,
    /// Over the width; positive where the helix deviates towards the right hand.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub helix_slope_um: Option<FigureBody>,
    /// Positive where material stands out half-way between root and tip.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile_crowning_um: Option<FigureBody>,
    /// Positive where material stands out half-way between the ends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub helix_crowning_um: Option<FigureBody>,
    /// 4 c_uv: how much more the profile slope is at the end of great z than at that of small z, in
    /// the sign of helix slopes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub twist_um: Option<FigureBody>,
    /// What the figures are over.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 2, max_items = 2)]
    pub roll_length_range_mm: Option<[f64; 2]>,
    /// The same along the width.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 2, max_items = 2)]
    pub z_range_mm: Option<[f64; 2]>,
    /// What to know about the figures, and why those are absent that are.
    pub warnings: Vec<NoticeBody>,
}

/// What figures of a flank are made of beside its fit.
#[derive(Clone, Debug)]
pub struct OfFlank {
    axes: AxesBody,
    side: Option<Side>,
    gear: Option<Gear>,
    limits: ToleranceLimits,
}

/// Whether nodes are told to be on a flank: what u, v and z of theirs are.
pub fn is_told(of: &Measurand) -> bool {
    of.axes.is_some() && AxesBody::of(of).is_ok_and(|axes| axes.u.is_some() && axes.v.is_some() && axes.z.is_some())
}

impl OfFlank {
    /// Of nodes of a job; `None` where they are not told to be on a flank.
    pub fn of(job: &Job, measurand: &Measurand) -> Option<Self> {
        let axes = AxesBody::of(measurand).ok().filter(|_| is_told(measurand))?;
        let gear = job.gear.as_deref().and_then(|document| of_text(document).ok());
        let required = RequirementsBody::of(job).unwrap_or_default();
        let limits = required.tolerance_limits.unwrap_or_default().of(measurand.flank.unwrap_or(Side::Left));
        Some(OfFlank { axes, side: measurand.flank, gear, limits })
    }

    /// What is to be asked of a fit, or why there is nothing to ask.
    pub fn ask(&self, nodes: &Nodes, spec: &FitSpec) -> Asked<'_> {
        let mut warnings = Vec::new();
        let flank = self.flank(nodes, spec).map_err(|why| warnings.push(why)).ok();
        // a class of which there is nothing bounds nothing
        let refused = flank.as_ref().and_then(|flank| self.limits.class_refused(flank.gear, true));
        warnings.extend(refused.as_ref().map(class_left_aside));
        if flank.is_some() && self.side.is_none() {
            warnings.push(notice("flank_assumed", "it is not told which flank it is; a left one is assumed"));
        }
        Asked { flank, limits: self.limits, warnings }
    }

    fn flank(&self, nodes: &Nodes, spec: &FitSpec) -> Result<FittedFlank<'_>, NoticeBody> {
        let unknown = |why: String| notice("axes_unknown", &why);
        let gear = self.gear.as_ref().ok_or_else(|| notice("no_gear", "the job has no gear"))?;
        if let Some(why) = not_second_order(spec) {
            return Err(notice("not_second_order", why));
        }
        if self.axes.traces().is_some() {
            let why = "each trace has a zero of its own; their evaluation tells the figures that they have";
            return Err(notice("traces_with_own_zeros", why));
        }
        let height = self.axes.deviation_factor().map_err(unknown)? / gear.base_helix_angle().cos();
        let v = self.axes.along().map_err(unknown)?;
        let (profile, unit) = self.axes.profile().map_err(unknown)?.ok_or_else(|| unknown("u is not told".into()))?;
        let axis = ProfileAxis::from(profile);
        // a value of the wire in the unit that the axis is taken in
        let u = profile.value(unit);
        let no_span = || notice("no_extent", "the nodes do not extend over the flank");
        let [(u_low, u_high), (v_low, v_high)] = spans(nodes).ok_or_else(no_span)?;
        let roll = |x: f64| {
            axis.roll_length(gear, u * x)
                .ok_or_else(|| notice("no_involute", "some nodes lie where the gear has no involute"))
        };
        Ok(FittedFlank {
            gear,
            side: self.side.unwrap_or(Side::Left),
            axis,
            u,
            v,
            height,
            roll_lengths: [roll(u_low)?, roll(u_high)?],
            z: [v * v_low, v * v_high],
        })
    }
}

/// What was asked of a fit.
pub struct Asked<'a> {
    pub flank: Option<FittedFlank<'a>>,
    limits: ToleranceLimits,
    warnings: Vec<NoticeBody>,
}

impl Asked<'_> {
    /// The document that is answered and kept, of what the fit says.
    pub fn answer(self, sums: Option<&[Option<WeightedSum>]>) -> String {
        let Asked { flank, limits, warnings } = self;
        let mut body = FitFiguresBody { warnings, ..FitFiguresBody::default() };
        match (flank, sums) {
            (Some(flank), Some(sums)) => {
                let found = flank.figures(sums, &limits).map(FigureBody::from);
                body.profile_slope_um = found.profile_slope;
                body.helix_slope_um = found.helix_slope;
                body.profile_crowning_um = found.profile_crowning;
                body.helix_crowning_um = found.helix_crowning;
                body.twist_um = found.twist;
                body.roll_length_range_mm = Some(flank.roll_lengths);
                body.z_range_mm = Some(flank.z);
                if sums.iter().any(Option::is_none) {
                    body.warnings.push(notice("beyond_double", "figures leave the range of double precision"));
                }
            }
            (Some(_), None) => {
                body.warnings.push(notice("rank_deficient", "the nodes do not determine the coefficients"));
            }
            (None, _) => {}
        }
        let whole = writer::whole(&body).ok().and_then(|bytes| String::from_utf8(bytes).ok());
        whole.unwrap_or_else(|| {
            let why = notice("beyond_double", "figures leave the range of double precision");
            writer::text_of(&FitFiguresBody { warnings: vec![why], ..FitFiguresBody::default() })
        })
    }
}

fn notice(code: &str, message: &str) -> NoticeBody {
    NoticeBody::new(code, &message)
}

/// Why a model tells no figures of second order.
fn not_second_order(spec: &FitSpec) -> Option<&'static str> {
    if spec.select.is_some() {
        return Some("the model was chosen among several; fit the chosen one to have its figures");
    }
    match &spec.model {
        Model::Polynomial { degree, terms: Terms::Total | Terms::Tensor, .. } => {
            let [u, v] = match *degree {
                Degree::Both(degree) => [degree; 2],
                Degree::Each(u, v) => [u, v],
            };
            (u < 2 || v < 2).then_some("a polynomial of second order at least, along u and along v, tells them")
        }
        Model::Polynomial { .. } => Some("of the terms of second order some may be missing"),
        Model::BSpline { .. } | Model::Linear => Some("a polynomial tells them, of second order at least"),
    }
}

/// What the counted nodes of a surface span along u and v.
fn spans(nodes: &Nodes) -> Option<[(f64, f64); 2]> {
    let span = |places: &mut dyn Iterator<Item = f64>| {
        let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        (high > low).then_some((low, high))
    };
    match nodes {
        Nodes::Scattered(nodes) => {
            let there = |k: &usize| !nodes.z()[*k].is_nan() && nodes.weight().is_none_or(|weight| weight[*k] > 0.0);
            let kept: Vec<usize> = (0..nodes.z().len()).filter(there).collect();
            let u = span(&mut kept.iter().map(|k| nodes.u()[*k]))?;
            Some([u, span(&mut kept.iter().map(|k| nodes.v()[*k]))?])
        }
        Nodes::Grid(grid) => {
            let there = |k: &usize| {
                !grid.z()[*k].is_nan()
                    && grid.valid().as_ref().is_none_or(|valid| valid[*k])
                    && grid.weight().is_none_or(|weight| weight[*k] > 0.0)
            };
            let columns = grid.v().len();
            let kept: Vec<usize> = (0..grid.z().len()).filter(there).collect();
            let u = span(&mut kept.iter().map(|k| grid.u()[k / columns]))?;
            Some([u, span(&mut kept.iter().map(|k| grid.v()[k % columns]))?])
        }
        Nodes::Curve(_) | Nodes::Matrix(_) => None,
    }
}
