//! Height over a rectangle or a cell of it: its Bernstein form, or for
//! surfaces that are no splines the sizes of its second derivatives among some places.

use super::{field::Field, form::Form};

/// Places along each parameter at which second derivatives and heights are sampled.
const LOOKS: u32 = 8;
/// Room for what lies between sampled places.
const SLACK: f64 = 2.0;

/// Height over a rectangle.
#[derive(Clone, Debug)]
pub(super) enum Heights {
    /// The height times the weight, and what weights and rounding do to it.
    Exact(Form, Margins),
    /// Bounds of |∂²/∂u²|, |∂²/∂u∂v| and |∂²/∂v²|, by samples.
    Sampled([f64; 3]),
}

/// How a form is to be read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Margins {
    /// The least and the greatest weight.
    pub weights: [f64; 2],
    /// Steps of coefficients that may be rounding.
    pub rounding: f64,
}

/// Judgement of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Judged {
    /// The height is 0 nowhere.
    Away,
    /// It is 0 everywhere.
    Within,
    /// It ascends or descends along a parameter.
    Monotone,
    Unknown,
}

impl Heights {
    /// By the second derivatives of the height over a rectangle.
    pub(super) fn sampled(field: &Field<'_>, range: [[f64; 2]; 2]) -> Self {
        let at = |[low, high]: [f64; 2], k: u32| low + (high - low) * (f64::from(k) / f64::from(LOOKS));
        let side = LOOKS + 1;
        let largest = (0..side * side).fold([0.0_f64; 3], |most, k| {
            let bend = field.at([at(range[0], k / side), at(range[1], k % side)]).bend;
            std::array::from_fn(|i| most[i].max(bend[i].abs()))
        });
        Heights::Sampled(largest.map(|bend| SLACK * bend))
    }

    /// How many numbers they are.
    pub(super) fn size(&self) -> usize {
        match self {
            Heights::Exact(form, _) => form.size(),
            Heights::Sampled(bends) => bends.len(),
        }
    }

    /// The same over the four quarters: low and high v of low u, then of high u.
    pub(super) fn quarters(&self) -> [Self; 4] {
        match self {
            Heights::Exact(form, margins) => {
                let [low, high] = form.divided(0, 0.5).map(|half| half.divided(1, 0.5));
                let [a, b] = low;
                let [c, d] = high;
                [a, b, c, d].map(|form| Heights::Exact(form, *margins))
            }
            Heights::Sampled(bends) => std::array::from_fn(|_| Heights::Sampled(*bends)),
        }
    }

    /// The same over a part whose ends are shares of the whole, `range` in parameters.
    pub(super) fn part(&self, field: &Field<'_>, shares: [[f64; 2]; 2], range: [[f64; 2]; 2]) -> Self {
        match self {
            Heights::Exact(form, margins) => Heights::Exact(form.part(shares), *margins),
            Heights::Sampled(_) => Heights::sampled(field, range),
        }
    }

    /// Judges their cell from `low` to `high`, where heights up to `contact` count as 0.
    pub(super) fn judge(&self, field: &Field<'_>, [low, high]: [[f64; 2]; 2], contact: f64) -> Judged {
        match self {
            Heights::Exact(form, Margins { weights: [light, heavy], rounding }) => {
                let [least, most] = form.hull();
                if least > contact * heavy || most < -contact * heavy {
                    Judged::Away
                } else if least >= -contact * light && most <= contact * light {
                    Judged::Within
                } else if (0..2).any(|axis| form.is_monotone(axis, *rounding)) {
                    Judged::Monotone
                } else {
                    Judged::Unknown
                }
            }
            Heights::Sampled(bends) => {
                let middle = [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])];
                let [hu, hv] = [0.5 * (high[0] - low[0]), 0.5 * (high[1] - low[1])];
                let local = field.at(middle);
                // what is found in the cell itself counts, where that is less
                let corners = [low, high, [low[0], high[1]], [high[0], low[1]]].map(|at| field.at(at).bend);
                let found = corners.iter().fold(local.bend.map(f64::abs), |most, bend| {
                    std::array::from_fn(|k| f64::max(most[k], bend[k].abs()))
                });
                let [uu, uv, vv]: [f64; 3] = std::array::from_fn(|k| bends[k].min(SLACK * found[k]));
                let [gu, gv] = local.slope.map(f64::abs);
                let swing =
                    gu * hu + gv * hv + 0.5 * (bends[0] * hu * hu + 2.0 * bends[1] * hu * hv + bends[2] * hv * hv);
                let rounding = 64.0 * f64::EPSILON * (local.jet.value.norm() + field.offset.abs());
                if local.height.abs() > swing + contact {
                    Judged::Away
                } else if local.height.abs() + swing <= contact {
                    Judged::Within
                } else if gu > uu * hu + uv * hv + rounding / hu || gv > uv * hu + vv * hv + rounding / hv {
                    Judged::Monotone
                } else {
                    Judged::Unknown
                }
            }
        }
    }

    /// Whether the height changes its sign at most once on the side where the parameter `axis` is
    /// at its lower (0) or upper (1) end.
    pub(super) fn passes_once(
        &self,
        field: &Field<'_>,
        [low, high]: [[f64; 2]; 2],
        (axis, end): (usize, usize),
        contact: f64,
    ) -> bool {
        let changes = |heights: &mut dyn Iterator<Item = f64>| {
            let mut last = None;
            heights
                .map(|height| height >= -contact)
                .filter(|above| last.replace(*above).is_some_and(|l| l != *above))
                .count()
        };
        let count = match self {
            Heights::Exact(form, margins) => changes(&mut form.side(axis, end).map(|c| c / margins.weights[1])),
            Heights::Sampled(_) => changes(&mut places([low, high], (axis, end), LOOKS).map(|at| field.height(at))),
        };
        count <= 1
    }

    /// Whether the height is 0 all along a side.
    pub(super) fn side_within(
        &self,
        field: &Field<'_>,
        [low, high]: [[f64; 2]; 2],
        (axis, end): (usize, usize),
        contact: f64,
    ) -> bool {
        match self {
            Heights::Exact(form, margins) => form.side(axis, end).all(|c| c.abs() <= contact * margins.weights[0]),
            Heights::Sampled(_) => {
                places([low, high], (axis, end), 2 * LOOKS).all(|at| field.height(at).abs() <= contact)
            }
        }
    }
}

/// Even places on the side where the parameter `axis` is at its lower (0) or upper (1) end.
fn places([low, high]: [[f64; 2]; 2], (axis, end): (usize, usize), steps: u32) -> impl Iterator<Item = [f64; 2]> {
    let across = 1 - axis;
    (0..=steps).map(move |k| {
        let mut at = [low, high][end];
        at[across] = low[across] + (high[across] - low[across]) * (f64::from(k) / f64::from(steps));
        at
    })
}
