//! The traces of one tooth flank together: samples as nodes of a surface, and the second-order surface that they tell.

use std::collections::BTreeMap;

use super::{
    EDGE, Position, Posted,
    flank_surface::{Border, FlankNodes, FlankSurface, SurfaceSettings, flank_surface, told},
    noise::noise,
    settings::{DeviationSign, Settings, SlopeSign, Window},
    spacing::Spacing,
};
use crate::numerics::cancel;
use crate::{
    estimation::{
        FitSpec,
        spec::{Model, Regularization, Scaling},
    },
    gear::{Gear, Kind, ProfileAxis, Side, trace::Direction},
};

/// Samples of one tooth flank, within the evaluation ranges: what lies beyond (the rounding of the tip) is no matter of the flank.
#[derive(Clone, Debug, PartialEq)]
pub struct FlankTraces {
    /// Without the letter of a trace beside the middle.
    pub tooth: String,
    pub side: Side,
    /// Roll length and z in mm, deviation about the design in µm, transverse, positive where material stands out.
    pub places: Vec<[f64; 3]>,
    traces: usize,
    /// Over the traces that tell their noise: Σ samples · variance, µm², and Σ samples.
    noise: [f64; 2],
}

/// The second-order surface of a tooth flank's traces.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceSurface {
    pub tooth: String,
    pub side: Side,
    pub traces: usize,
    pub surface: FlankSurface,
}

/// Tooth by tooth and flank by flank the traces whose section is known, the flank with most traces first.
pub fn flank_traces(gear: &Gear, posted: &[Posted], settings: &Settings) -> Vec<FlankTraces> {
    let rolls = settings.profile.and_then(|asked| {
        let [a, b] = asked.diameters.map(|diameter| gear.roll_length(diameter));
        Some([a?.min(b?), a?.max(b?)])
    });
    let helix = settings.helix.map(|asked| asked.range);
    let within = |x: f64, range: Option<[f64; 2]>| range.is_none_or(|[low, high]| low - EDGE <= x && x <= high + EDGE);
    let along = match settings.direction {
        Direction::Transverse => 1.0,
        Direction::Normal => 1.0 / gear.base_helix_angle().cos(),
    };
    let mut flanks: BTreeMap<(&str, Side), FlankTraces> = BTreeMap::new();
    for Posted { trace, design } in posted {
        cancel::checkpoint();
        let Some(section) = trace.section else { continue };
        let fixed = if trace.kind == Kind::Profile { Some(section) } else { gear.roll_length(section) };
        let Some(fixed) = fixed else { continue };
        let tooth = Position::split(&trace.tooth).0;
        let flank = flanks.entry((tooth, trace.side)).or_insert_with(|| FlankTraces {
            tooth: tooth.to_owned(),
            side: trace.side,
            places: Vec::new(),
            traces: 0,
            noise: [0.0; 2],
        });
        let before = flank.places.len();
        let scale = along * settings.given.to_material(trace.kind, trace.side);
        for (k, (&at, &deviation)) in trace.at.iter().zip(&trace.deviation).enumerate() {
            let about = deviation - design.map_or(0.0, |design| design[k]);
            let [roll, z] = if trace.kind == Kind::Profile { [at, fixed] } else { [fixed, at] };
            if within(roll, rolls) && within(z, helix) && about.is_finite() {
                flank.places.push([roll, z, scale * about]);
            }
        }
        let own = &flank.places[before..];
        flank.traces += usize::from(!own.is_empty());
        if let Some(found) = trace_noise(own, usize::from(trace.kind == Kind::Helix)) {
            flank.noise[0] += found * found * own.len() as f64;
            flank.noise[1] += own.len() as f64;
        }
    }
    let mut flanks: Vec<FlankTraces> = flanks.into_values().filter(|flank| !flank.places.is_empty()).collect();
    flanks.sort_by_key(|flank| std::cmp::Reverse(flank.traces));
    flanks
}

/// Noise of the samples of one trace, which runs along coordinate `along` of its places.
fn trace_noise(places: &[[f64; 3]], along: usize) -> Option<f64> {
    let mut each: Vec<[f64; 2]> = places.iter().map(|place| [place[along], place[2]]).collect();
    each.sort_by(cancel::comparing(|a: &[f64; 2], b: &[f64; 2]| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))));
    let (low, high) = (each.first()?[0], each.last()?[0]);
    let u: Vec<f64> = each.iter().map(|[x, _]| (2.0 * x - low - high) / (high - low)).collect();
    let deviation: Vec<f64> = each.iter().map(|[_, deviation]| *deviation).collect();
    noise(&u, &deviation, &Spacing::of(&u)).filter(|noise| noise.is_finite())
}

impl FlankTraces {
    /// How many of its traces have samples there.
    pub fn traces(&self) -> usize {
        self.traces
    }

    /// `None` where the traces do not tell all six terms: a plain cross of one profile and one helix says nothing of the twist.
    fn surface(
        &self,
        gear: &Gear,
        [profile, helix]: [Option<&Window>; 2],
        settings: &Settings,
    ) -> Option<TraceSurface> {
        let column = |c: usize| self.places.iter().map(|place| place[c]).collect::<Vec<f64>>();
        let (rolls, z, deviation) = (column(0), column(1), column(2));
        let nodes = FlankNodes {
            axis: ProfileAxis::RollLength,
            profile: &rolls,
            z: &z,
            deviation: &deviation,
            valid: None,
            grid: false,
        };
        let asked = SurfaceSettings {
            side: self.side,
            profile_range: profile.map(|window| [window.low, window.high]),
            helix_range: helix.map(|window| [window.low, window.high]),
            border: Border::default(),
            given: DeviationSign::Material,
            // the sign asked for is that of traces, see below
            sign: SlopeSign::Vdi,
            spec: FitSpec {
                regularization: Regularization::None,
                scaling: Scaling::None,
                ..FitSpec::new(Model::Linear)
            },
        };
        // what cannot be fitted is not told
        let mut surface = flank_surface(gear, &nodes, &asked).ok().filter(|surface| told(&surface.result))?;
        let sign = |kind| settings.sign.of_material(settings.given, kind, self.side);
        surface.profile_slope = surface.profile_slope.times(sign(Kind::Profile));
        surface.helix_slope = surface.helix_slope.times(sign(Kind::Helix));
        surface.twist = surface.twist.times(sign(Kind::Helix));
        // what the surface leaves is mostly form, which comes again: errors are those of the traces' noise
        let noise = (self.noise[1] > 0.0).then(|| (self.noise[0] / self.noise[1]).sqrt());
        let factor = noise.zip(surface.result.residuals.sigma.filter(|s| *s > 0.0)).map(|(noise, sigma)| noise / sigma);
        for figure in [
            &mut surface.mean,
            &mut surface.profile_slope,
            &mut surface.helix_slope,
            &mut surface.profile_crowning,
            &mut surface.helix_crowning,
            &mut surface.twist,
        ] {
            figure.std_error = figure.std_error.zip(factor).map(|(error, factor)| error * factor);
        }
        Some(TraceSurface { tooth: self.tooth.clone(), side: self.side, traces: self.traces, surface })
    }
}

/// The surfaces of the flanks whose traces tell one, in the order of teeth, left flanks first; over the evaluation ranges.
pub(super) fn surfaces(
    gear: &Gear,
    posted: &[Posted],
    windows: [Option<&Window>; 2],
    settings: &Settings,
) -> Vec<TraceSurface> {
    let flanks = flank_traces(gear, posted, settings);
    let mut surfaces: Vec<TraceSurface> =
        flanks.iter().filter_map(|flank| flank.surface(gear, windows, settings)).collect();
    let number = |tooth: &str| Position::number(tooth).unwrap_or(u64::MAX);
    surfaces.sort_by(|a, b| (number(&a.tooth), &a.tooth, a.side).cmp(&(number(&b.tooth), &b.tooth, b.side)));
    surfaces
}
