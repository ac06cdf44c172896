//! The flank that the nodes of a correction lie on: its figures, and the deviations that it can be
//! given as a target.

use super::{
    figures::{HeldFigure, MEAN, ROUNDING},
    machine::{FlankNode, Ranges},
    problem::CorrectionSpec,
    scatter::Scatter,
};
use crate::{
    Gear, Modifications, ProfileAxis, Side,
    evaluation::{
        ToleranceLimits, figures_of_traces,
        flank_surface::{
            Border, EstimatedFigure, FigureTerms, FlankFigures, FlankNodes, Slopes, SurfaceSettings, estimated_figures,
        },
        settings::{DeviationSign, SlopeSign},
    },
    modification::{Flanks, Law, Modification, Range},
    trace::Direction,
};
use flankfit_estimation::{
    self, FitSpec, Nodes,
    spec::{Degree, Model, PolynomialBasis, Regularization, Terms},
};
use flankfit_numerics::{cancel::Asking, check::Faults};

/// Degrees of freedom from which on the noise that is left over is well enough known.
pub const LEAST_FREEDOM: usize = 10;

/// A flank that the nodes lie on.
#[derive(Clone, Debug, PartialEq)]
pub struct Flank {
    /// Its gear.
    pub gear: Gear,
    /// Which flank of the tooth it is.
    pub side: Side,
    /// Places of the nodes.
    pub places: Vec<FlankNode>,
    /// Ranges of the figures.
    pub ranges: Ranges,
    /// The trace of each node, where every trace has a zero of its own.
    pub traces: Option<Vec<usize>>,
    /// Direction and reference lengths of the figures.
    pub terms: FigureTerms,
}

/// How a flank is meant to deviate from the involute.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Design {
    /// Slopes, crownings and twist, µm, in the signs and the direction of the figures.
    pub figures: FlankFigures,
    /// Further modifications.
    pub modifications: Vec<Modification>,
    /// Roll lengths that all of them refer to, mm; by default those of the nodes, with slopes over
    /// their reference lengths.
    pub profile: Option<[f64; 2]>,
    /// z that all of them refer to, mm; by default likewise.
    pub helix: Option<[f64; 2]>,
}

impl Design {
    /// Returns the modifications of a flank. `ranges` are those of what was measured; the figures
    /// have `terms`, and stand behind the modifications in their list.
    pub fn on(&self, gear: &Gear, side: Side, ranges: Ranges, terms: FigureTerms) -> Result<Modifications, Faults> {
        let profile = self.profile.unwrap_or(ranges.profile);
        let helix = self.helix.unwrap_or(ranges.helix);
        let range = Range::of_roll_lengths(gear, profile, helix)?;
        // what is removed is counted in a law, what protrudes in a figure; DIN counts helices
        // towards the right hand
        let hand = side.sign();
        let Slopes { factors, .. } = Slopes::of_nodes(gear, terms, [ranges.profile, ranges.helix]);
        let along = terms.factor(gear, Direction::Normal);
        let FlankFigures { profile_slope, helix_slope, profile_crowning, helix_crowning, twist } =
            self.figures.map(|amount| amount / along);
        // without a range of its own a slope is over its reference length
        let profile_slope = profile_slope.map(|amount| amount / self.profile.map_or(factors[0], |_| 1.0));
        let helix_slope = helix_slope.map(|amount| amount / self.helix.map_or(factors[1], |_| 1.0));
        let laws = [
            profile_slope.map(|amount| Law::ProfileSlope { amount: -amount }),
            helix_slope.map(|amount| Law::HelixSlope { amount: -hand * amount }),
            profile_crowning.map(|amount| Law::ProfileCrowning { amount }),
            helix_crowning.map(|amount| Law::HelixCrowning { amount }),
            twist.map(|amount| Law::Twist { amount: -hand * amount }),
        ];
        let figures = laws.into_iter().flatten().map(|law| Modification { flanks: Flanks::Both, law });
        let list = self.modifications.iter().cloned().chain(figures).collect();
        Modifications::new(gear, range, list).map_err(|found| found.within("modifications"))
    }
}

impl Flank {
    /// The figures of `deviation` (µm, an entry for each node, NaN where undefined) over the
    /// ranges, by the nodes of a `weight` above 0; signs of ISO 1328-1 with DIN's for slopes.
    /// `None` where the nodes do not tell them.
    pub fn figures(&self, deviation: &[f64], weight: Option<&[f64]>) -> Option<FlankFigures> {
        Some(self.estimated_figures(deviation, weight)?.map(|figure| figure.value))
    }

    /// The same with the errors of each.
    pub fn estimated_figures(
        &self,
        deviation: &[f64],
        weight: Option<&[f64]>,
    ) -> Option<FlankFigures<EstimatedFigure>> {
        let [root, tip] = self.ranges.profile;
        if let Some(traces) = self.traces.as_ref().filter(|traces| traces.len() == deviation.len()) {
            let counts = |k: usize| weight.is_none_or(|weight| weight[k] > 0.0);
            let node = |(k, place): (usize, &FlankNode)| {
                let height = if counts(k) { deviation[k] } else { f64::NAN };
                ([place.roll_length, place.z, height], traces[k])
            };
            let nodes: Vec<_> = self.places.iter().enumerate().map(node).collect();
            return figures_of_traces(
                &nodes,
                [[root.min(tip), root.max(tip)], self.ranges.helix],
                &self.gear,
                self.side,
                self.terms,
            );
        }
        let valid: Vec<bool> = (0..deviation.len()).map(|k| weight.is_none_or(|weight| weight[k] > 0.0)).collect();
        let of = |coordinate: fn(&FlankNode) -> f64| self.places.iter().map(coordinate).collect::<Vec<f64>>();
        let (profile, z) = (of(|place| place.roll_length), of(|place| place.z));
        let nodes = FlankNodes {
            axis: ProfileAxis::RollLength,
            profile: &profile,
            z: &z,
            deviation,
            valid: Some(&valid),
            grid: false,
        };
        let settings = SurfaceSettings {
            side: self.side,
            profile_range: Some([root.min(tip), root.max(tip)]),
            helix_range: Some(self.ranges.helix),
            border: Border::default(),
            given: DeviationSign::Material,
            direction: Direction::Normal,
            terms: self.terms,
            sign: SlopeSign::Din,
            limits: ToleranceLimits::default(),
            spec: FitSpec::new(Model::Linear),
        };
        estimated_figures(&self.gear, &nodes, &settings)
    }

    /// Returns the standard deviation of a deviation of weight 1, µm, from what a surface of second
    /// order leaves. Unlike the residuals of the settings it holds no shape that a setting is not
    /// changed for. `None` with fewer than [`LEAST_FREEDOM`] degrees of freedom, and where every
    /// trace has a zero of its own.
    pub fn noise(&self, deviation: &[f64], weight: Option<&[f64]>) -> Option<f64> {
        if self.traces.is_some() {
            return None;
        }
        let counts = |k: &usize| deviation[*k].is_finite() && weight.is_none_or(|weight| weight[*k] > 0.0);
        let counted: Vec<usize> = (0..deviation.len()).filter(counts).collect();
        let of = |value: &dyn Fn(usize) -> f64| counted.iter().map(|&k| value(k)).collect::<Vec<f64>>();
        let nodes = Nodes::scattered(
            of(&|k| self.places[k].roll_length),
            of(&|k| self.places[k].z),
            of(&|k| deviation[k]),
            weight.map(|weight| of(&|k| weight[k])),
        );
        let model =
            Model::Polynomial { degree: Degree::Both(2), basis: PolynomialBasis::Legendre, terms: Terms::Total };
        let spec = FitSpec { regularization: Regularization::None, ..FitSpec::new(model) };
        let left = flankfit_estimation::fit(&nodes.ok()?, &spec).ok()?.residuals;
        left.sigma.filter(|sigma| *sigma > 0.0 && left.degrees_of_freedom >= LEAST_FREEDOM)
    }

    /// Returns the lengths that the slopes of profile and helix refer to, mm.
    pub fn references(&self) -> [f64; 2] {
        Slopes::of_nodes(&self.gear, self.terms, [self.ranges.profile, self.ranges.helix]).references
    }

    /// The deviations of a flank made as designed, µm for each node.
    pub fn designed(&self, design: &Design) -> Result<Vec<f64>, Faults> {
        let modifications = design.on(&self.gear, self.side, self.ranges, self.terms)?;
        let deviation = |place: &FlankNode| 0.0 - modifications.relief(self.side, place.roll_length, place.z).value;
        Ok(self.places.iter().asking(100).map(deviation).collect())
    }

    /// The target that moves each figure with limits to their middle and leaves the rest of the
    /// surface of second order as measured: `t = S(d) − Σ (figure − middle) · its shape`, so that
    /// `d − t` is that sum and what the surface leaves over. `None` where the nodes do not tell the
    /// figures.
    pub fn target_within(
        &self,
        deviation: &[f64],
        weight: Option<&[f64]>,
        limits: FlankFigures<[f64; 2]>,
    ) -> Option<Vec<f64>> {
        let measured = self.figures(deviation, weight)?;
        let shapes = self.shapes(deviation, weight)?;
        let mut target = vec![self.level(deviation, deviation, weight, &measured, &shapes); deviation.len()];
        let named = measured.named().into_iter().zip(shapes.named()).zip(limits.named());
        for (((_, value), (_, shape)), (_, limits)) in named {
            let (Some(value), Some(shape)) = (value, shape) else { continue };
            let value = limits.map_or(value, |[low, high]| 0.5 * (low + high));
            target.iter_mut().zip(shape).for_each(|(target, x)| *target += value * x);
        }
        Some(target)
    }

    /// The figures as the settings of `spec` move them, with the level where the deviations have a
    /// datum; empty where the nodes do not tell them.
    pub fn held(&self, spec: &CorrectionSpec, limits: FlankFigures<[f64; 2]>) -> Vec<HeldFigure> {
        self.held_figures(spec, limits).unwrap_or_default()
    }

    fn held_figures(&self, spec: &CorrectionSpec, limits: FlankFigures<[f64; 2]>) -> Option<Vec<HeldFigure>> {
        let (deviation, weight) = (&spec.deviation[..], spec.weight.as_deref());
        let (nodes, columns) = (deviation.len(), spec.settings.len());
        let defined = |of: &dyn Fn(usize) -> f64| -> Vec<f64> {
            (0..nodes).map(|k| if deviation[k].is_nan() { f64::NAN } else { of(k) }).collect()
        };
        let measured = self.scattered_figures(deviation, weight, &spec.scatter)?;
        let target = defined(&|k| spec.target.as_ref().map_or(0.0, |target| target[k]));
        let moved: Vec<Vec<f64>> = (0..columns).map(|j| defined(&|k| spec.sensitivity[k * columns + j])).collect();
        let of_moved: Option<Vec<FlankFigures>> = moved.iter().map(|column| self.figures(column, weight)).collect();
        let (of_target, of_moved) = (self.figures(&target, weight)?, of_moved?);
        // the figures of a design that it does not have are rounding errors
        let least = ROUNDING * target.iter().filter(|t| !t.is_nan()).fold(0.0, |most: f64, t| most.max(t.abs()));
        let aimed = |value: f64| if value.abs() <= least { 0.0 } else { value };
        let mut held = Vec::new();
        for (i, (name, figure)) in measured.named().into_iter().enumerate() {
            // no negative zero
            let of = |figures: &FlankFigures| figures.named()[i].1.unwrap_or(0.0) + 0.0;
            held.extend(figure.map(|measured| HeldFigure {
                side: self.side,
                name,
                measured,
                target: aimed(of(&of_target)),
                moved: of_moved.iter().map(of).collect(),
                limits: limits.named()[i].1,
            }));
        }
        if spec.absolute {
            let shapes = self.shapes(deviation, weight)?;
            let level = |list: &[f64], figures: &FlankFigures| self.level(list, deviation, weight, figures, &shapes);
            let value = level(deviation, &measured.map(|figure| figure.value));
            held.push(HeldFigure {
                side: self.side,
                name: MEAN,
                measured: EstimatedFigure::new(value, None, 0, 1.0),
                target: aimed(level(&target, &of_target)),
                moved: moved.iter().zip(&of_moved).map(|(column, figures)| level(column, figures)).collect(),
                limits: None,
            });
        }
        Some(held)
    }

    /// The figures with the greater of their standard errors by noise and by the scatter of teeth.
    pub fn scattered_figures(
        &self,
        deviation: &[f64],
        weight: Option<&[f64]>,
        scatter: &Scatter,
    ) -> Option<FlankFigures<EstimatedFigure>> {
        let measured = self.estimated_figures(deviation, weight)?;
        let mut squares: Option<FlankFigures> = None;
        for column in &scatter.columns {
            let defined = column.iter().zip(deviation).map(|(e, d)| if d.is_nan() { f64::NAN } else { *e });
            let figures = self.figures(&defined.collect::<Vec<f64>>(), weight)?.map(|x| x * x);
            squares = Some(squares.map_or(figures, |sums| sums.zip(figures).map(|(sum, square)| sum + square)));
        }
        let greater = |(figure, square): (EstimatedFigure, f64)| match figure.std_error {
            Some(error) if error >= square.sqrt() => figure,
            None if square == 0.0 => figure,
            _ => EstimatedFigure::new(figure.value, Some(square.sqrt()), scatter.freedom, 1.0),
        };
        Some(squares.map_or(measured, |squares| measured.zip(squares).map(greater)))
    }

    /// The surface, at each node, on which each figure is 1 and the others are 0.
    fn shapes(&self, deviation: &[f64], weight: Option<&[f64]>) -> Option<FlankFigures<Vec<f64>>> {
        let along = |x: f64, [from, to]: [f64; 2]| ((x - from) + (x - to)) / (to - from);
        let shape = |of: fn(f64, f64) -> f64, figure: fn(FlankFigures) -> Option<f64>| {
            let basis = |place: &FlankNode| {
                of(along(place.roll_length, self.ranges.profile), along(place.z, self.ranges.helix))
            };
            let basis: Vec<f64> = self.places.iter().map(basis).collect();
            let defined: Vec<f64> =
                basis.iter().zip(deviation).map(|(x, d)| if d.is_nan() { f64::NAN } else { *x }).collect();
            let size = figure(self.figures(&defined, weight)?)?;
            Some(basis.iter().map(|x| x / size).collect())
        };
        Some(FlankFigures {
            profile_slope: shape(|u, _| u, |figures| figures.profile_slope),
            helix_slope: shape(|_, v| v, |figures| figures.helix_slope),
            profile_crowning: shape(|u, _| u * u, |figures| figures.profile_crowning),
            helix_crowning: shape(|_, v| v * v, |figures| figures.helix_crowning),
            twist: shape(|u, v| u * v, |figures| figures.twist),
        })
    }

    /// The constant of the surface through `list` that has these figures: the mean of what they
    /// leave over the nodes that are defined and counted.
    fn level(
        &self,
        list: &[f64],
        deviation: &[f64],
        weight: Option<&[f64]>,
        figures: &FlankFigures,
        shapes: &FlankFigures<Vec<f64>>,
    ) -> f64 {
        let inside = |x: f64, [a, b]: [f64; 2]| (a.min(b)..=a.max(b)).contains(&x);
        let counts = |k: &usize| {
            let place = &self.places[*k];
            !deviation[*k].is_nan()
                && weight.is_none_or(|weight| weight[*k] > 0.0)
                && inside(place.roll_length, self.ranges.profile)
                && inside(place.z, self.ranges.helix)
        };
        let (mut sum, mut count) = (0.0, 0usize);
        let named: Vec<_> = figures.named().into_iter().zip(shapes.as_refs().named()).collect();
        for k in (0..list.len()).filter(counts) {
            let surface: f64 = named.iter().filter_map(|((_, value), (_, shape))| Some((*value)? * (*shape)?[k])).sum();
            sum += list[k] - surface;
            count += 1;
        }
        if count == 0 { 0.0 } else { sum / count as f64 }
    }
}
