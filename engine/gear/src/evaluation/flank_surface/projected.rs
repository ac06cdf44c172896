//! The named figures of a surface that was fitted for itself, whatever its basis and degree: those
//! of the surface of second order that is nearest to it.
//!
//! Over the range, roll length and z are mapped to [-1, 1]² as for [`super::flank_surface()`]. In
//! Legendre polynomials the fitted surface is `Σ a_ij P_i(u) P_j(v)`, and what is left of it up to
//! `i + j = 2` is nearest in the mean square. With `a_ij = (2i+1)(2j+1)/4 ∬ f P_i P_j` the
//! figures are
//!
//! | figure | is |
//! |---|---|
//! | profile slope, helix slope | 2 a₁₀, 2 a₀₁ |
//! | profile crowning, lengthwise crowning | −3/2 a₂₀, −3/2 a₀₂ |
//! | twist | 4 a₁₁ |
//!
//! The integrals are sums by Gauss's rule, exact up to degree 29 on each axis. So each figure is a
//! linear form of the fit's own coefficients, and has its standard error, bias bound and interval
//! from the fit itself. Of a surface of second order they are its coefficients over the mapped
//! range. Nodes over diameters are fitted over their roll lengths ([`super::over_roll_lengths`]).

use super::{
    super::{
        limits::ToleranceLimits,
        settings::{DeviationSign, SlopeSign},
    },
    Figure, FigureTerms, FlankFigures, Slopes,
};
use crate::{Gear, Kind, Side, tolerance::Tolerances, trace::Direction};
use flankfit_estimation::{inference::Doubts, result::WeightedSum, spec::WeightedSums};
use flankfit_numerics::quadrature::gauss_legendre;

/// Places on each axis.
const POINTS: usize = 16;
/// P_i P_j of the figures: slopes, crownings, twist.
const ORDERS: [[usize; 2]; 5] = [[1, 0], [0, 1], [2, 0], [0, 2], [1, 1]];

/// A flank that a surface was fitted to.
#[derive(Clone, Copy, Debug)]
pub struct FittedFlank<'a> {
    /// Its gear.
    pub gear: &'a Gear,
    /// Flank of the tooth.
    pub side: Side,
    /// Factor from u to the roll length in mm.
    pub u: f64,
    /// Factor by which v is multiplied to be z in mm.
    pub v: f64,
    /// Factor from heights to µm of material along the normal.
    pub height: f64,
    /// Direction and reference lengths of the figures.
    pub terms: FigureTerms,
    /// Range in roll length, mm, ascending.
    pub roll_lengths: [f64; 2],
    /// Range in z, mm, ascending.
    pub z: [f64; 2],
}

impl FittedFlank<'_> {
    /// Sums that the fit has to return.
    pub fn sums(&self) -> WeightedSums {
        let rule: Vec<[f64; 2]> = gauss_legendre(POINTS).iter().map(|(x, w)| [x.to_f64(), w.to_f64()]).collect();
        let along = |[low, high]: [f64; 2], x: f64| 0.5 * (low + high) + 0.5 * (high - low) * x;
        let place = |x: f64, y: f64| {
            let roll = along(self.roll_lengths, self.gear.outward() * x);
            [roll / self.u, along(self.z, y) / self.v]
        };
        let pairs = || rule.iter().flat_map(|x| rule.iter().map(move |y| (*x, *y)));
        let weights = |[i, j]: [usize; 2]| {
            let norm = ((2 * i + 1) * (2 * j + 1)) as f64 / 4.0;
            pairs().map(|([x, w], [y, h])| norm * w * h * legendre(i, x) * legendre(j, y)).collect()
        };
        WeightedSums {
            places: pairs().map(|([x, _], [y, _])| place(x, y)).collect(),
            weights: ORDERS.into_iter().map(weights).collect(),
        }
    }

    /// Returns the figures, slopes by DIN, of the results for [`FittedFlank::sums`], compared with
    /// limits; `doubts` are those of the fit.
    pub fn figures(
        &self,
        sums: &[Option<WeightedSum>],
        limits: FlankFigures<[f64; 2]>,
        doubts: Doubts,
    ) -> FlankFigures<Figure> {
        let [profile, helix] = [Kind::Profile, Kind::Helix]
            .map(|kind| SlopeSign::Din.of_material(DeviationSign::Material, kind, self.side));
        let Slopes { factors, .. } = self.slopes();
        let height = self.height * self.terms.factor(self.gear, Direction::Normal);
        let figure = |k: usize, factor: f64, limits: Option<[f64; 2]>| {
            let sum = sums.get(k)?.as_ref()?;
            Some(Figure::new(sum, factor * height, limits, doubts))
        };
        FlankFigures {
            profile_slope: figure(0, 2.0 * profile * factors[0], limits.profile_slope),
            helix_slope: figure(1, 2.0 * helix * factors[1], limits.helix_slope),
            profile_crowning: figure(2, -1.5, limits.profile_crowning),
            helix_crowning: figure(3, -1.5, limits.helix_crowning),
            twist: figure(4, 4.0 * helix, limits.twist),
        }
    }

    /// Returns the lengths that the slopes of profile and helix refer to, mm. L_α is the range of
    /// the nodes.
    pub fn references(&self) -> [f64; 2] {
        self.slopes().references
    }

    fn slopes(&self) -> Slopes {
        Slopes::of_nodes(self.gear, self.terms, [self.roll_lengths, self.z])
    }
}

/// Returns the limits of the figures of nodes over `ranges` of roll length and z.
pub fn figure_limits(
    gear: &Gear,
    terms: FigureTerms,
    ranges: [[f64; 2]; 2],
    limits: &ToleranceLimits,
) -> FlankFigures<[f64; 2]> {
    let slopes = Slopes::of_nodes(gear, terms, ranges);
    let [profile_slope, helix_slope] = slopes.limits(limits, Tolerances::new(gear).ok().as_ref());
    FlankFigures {
        profile_slope,
        helix_slope,
        profile_crowning: limits.profile_crowning_um,
        helix_crowning: limits.helix_crowning_um,
        twist: limits.twist_um,
    }
}

/// P₀, P₁ or P₂.
fn legendre(order: usize, x: f64) -> f64 {
    match order {
        0 => 1.0,
        1 => x,
        _ => 1.5 * x * x - 0.5,
    }
}
