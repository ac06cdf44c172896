//! A fit over diameters, repeated over roll lengths.
//!
//! The figures of a profile are defined over roll length, `L = √(d²/4 − r_b²)`. It is no linear
//! function of the diameter, so a surface of second order over one is none over the other: with the
//! nearest surface over diameters f_Hα takes up a part of C_α. The figures are therefore those of
//! the same fit of the same heights over `L`.

use std::sync::Arc;

use crate::Gear;
use flankfit_estimation::{
    FitSpec, Nodes,
    spec::{Chain, Corrected, Domain, Earlier, ExpectedSize, JamesStein, Moves, Prior, Regularization},
};

/// Why there is no fit over roll lengths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoRollLengths {
    /// Some diameters are smaller than that of the base circle.
    NoInvolute,
    /// The spec has values of coefficients, which are those of a surface over diameters.
    Coefficients,
}

/// Returns nodes and spec with roll lengths (mm) in place of diameters; `mm` is the factor from u
/// to the diameter in mm.
pub fn over_roll_lengths(
    gear: &Gear,
    mm: f64,
    nodes: &Nodes,
    spec: &FitSpec,
) -> Result<(Nodes, FitSpec), NoRollLengths> {
    if has_coefficients(spec) {
        return Err(NoRollLengths::Coefficients);
    }
    let along = Along { gear, mm };
    let domain = match spec.domain {
        Some(Domain { u: Some([from, to]), v }) => Some(Domain { u: Some([along.roll(from)?, along.roll(to)?]), v }),
        other => other,
    };
    let prior = match &spec.prior {
        Some(Prior::Iterations(chain)) => Some(Prior::Iterations(along.chain(chain)?)),
        other => other.clone(),
    };
    Ok((along.nodes(nodes)?, FitSpec { domain, prior, predict: None, ..spec.clone() }))
}

/// True if a spec has values of single coefficients.
fn has_coefficients(spec: &FitSpec) -> bool {
    let of_prior = match &spec.prior {
        Some(Prior::Given { .. }) => true,
        Some(Prior::Iterations(chain)) => matches!(chain.moves, Moves::StdError(_)),
        None => false,
    };
    let of_target = matches!(
        spec.regularization,
        Regularization::Attraction(_) | Regularization::JamesStein(JamesStein { target: Some(_), .. })
    );
    of_prior || of_target || matches!(spec.expected_size, ExpectedSize::Within(_))
}

struct Along<'a> {
    gear: &'a Gear,
    mm: f64,
}

impl Along<'_> {
    fn roll(&self, u: f64) -> Result<f64, NoRollLengths> {
        self.gear.roll_length(self.mm * u).ok_or(NoRollLengths::NoInvolute)
    }

    fn nodes(&self, nodes: &Nodes) -> Result<Nodes, NoRollLengths> {
        nodes.clone().try_map_u(|u| self.roll(u))
    }

    fn chain(&self, chain: &Chain) -> Result<Chain, NoRollLengths> {
        let correction = |one: &Corrected| Ok(Corrected { change: Arc::new(self.nodes(&one.change)?), ..one.clone() });
        let iteration = |one: &Earlier| {
            let corrections = one.corrections.iter().map(correction).collect::<Result<_, _>>()?;
            Ok(Earlier { nodes: Arc::new(self.nodes(&one.nodes)?), corrections, ..one.clone() })
        };
        let earlier = chain.earlier.as_ref().map(|all| all.iter().map(iteration).collect::<Result<_, _>>());
        Ok(Chain { earlier: earlier.transpose()?, ..chain.clone() })
    }
}
