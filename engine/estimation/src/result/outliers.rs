//! Nodes that are suspected of gross errors.

use std::fmt;

use flankfit_numerics::words::{Size, listed, rounded};

/// Greatest number of nodes named in a sentence.
const NAMED: usize = 5;
/// From this many suspected nodes on, the errors may equally well have a heavy-tailed distribution.
const HEAVY_TAILS: usize = 3;

/// Nodes that are suspected of gross errors, and the fit without them.
#[derive(Clone, Debug, PartialEq)]
pub struct Outliers {
    /// The nodes, the most striking one first.
    pub nodes: Vec<SuspectedNode>,
    /// The coefficients with and without these nodes; empty where there is no fit without them.
    pub coefficients: Vec<MovedCoefficient>,
}

/// A node that deviates from the fit of the others by more than noise explains.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "contract", serde_with_macros::skip_serializing_none, derive(serde::Serialize))]
pub struct SuspectedNode {
    /// Its index among the posted nodes.
    pub index: usize,
    /// Its row in a grid.
    pub row: Option<usize>,
    /// Its column in a grid.
    pub column: Option<usize>,
    /// Its abscissae: x of a curve, u and v of a surface, none of a measurement matrix.
    pub place: Vec<f64>,
    /// Its height.
    pub height: f64,
    /// Height minus the least-squares fit of the nodes that are not suspected.
    pub off: f64,
    /// The same in standard deviations of a height of this weight.
    pub off_sigmas: f64,
}

/// A coefficient with and without the suspected nodes.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "contract", serde_with_macros::skip_serializing_none, derive(serde::Serialize))]
pub struct MovedCoefficient {
    /// Name of the term.
    pub term: String,
    /// Estimate with the suspected nodes.
    pub value: f64,
    /// Estimate without them.
    pub without: f64,
    /// Half-width of the confidence interval without them, if there is one.
    pub half_width: Option<f64>,
    /// True if the suspected nodes change it by more than that.
    pub exceeds_interval: bool,
}

impl Outliers {
    /// Returns the coefficients that the suspected nodes change by more than the half-width of
    /// their intervals.
    pub fn moved(&self) -> impl Iterator<Item = &MovedCoefficient> + Clone {
        self.coefficients.iter().filter(|coefficient| coefficient.exceeds_interval)
    }
}

/// Lists hold 64 coefficients at most.
#[cfg(feature = "contract")]
impl serde::Serialize for Outliers {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeStruct;
        const LISTED: usize = 64;
        let mut fields = serializer.serialize_struct("Outliers", 5)?;
        fields.serialize_field("nodes", &self.nodes)?;
        fields.serialize_field("count", &self.nodes.len())?;
        fields.serialize_field("coefficients", &self.coefficients[..self.coefficients.len().min(LISTED)])?;
        fields.serialize_field("moved", &self.moved().take(LISTED).map(|one| &one.term).collect::<Vec<_>>())?;
        fields.serialize_field("exceeds_interval", &self.moved().next().is_some())?;
        fields.end()
    }
}

impl fmt::Display for SuspectedNode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "node {}", self.index)?;
        if let (Some(row), Some(column)) = (self.row, self.column) {
            write!(f, " (row {row}, column {column})")?;
        }
        write!(f, " by {} ({:.1} σ)", Size(self.off), self.off_sigmas.abs())
    }
}

impl fmt::Display for Outliers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = self.nodes.len();
        let (nodes, are, them) = if count == 1 { ("node", "is", "it") } else { ("nodes", "are", "them") };
        let more = if count > NAMED { ", …" } else { "" };
        let named = listed(self.nodes.iter().take(NAMED));
        write!(f, "{count} {nodes} {are} farther from the fit to the others than noise explains: {named}{more}")?;
        let mut moved = self.moved().peekable();
        if moved.peek().is_some() {
            let of = |c: &MovedCoefficient| {
                format!("{} ({} instead of {})", c.term, rounded(c.without, 4), rounded(c.value, 4))
            };
            let more = if self.moved().count() > NAMED { ", …" } else { "" };
            let moved: Vec<String> = moved.take(NAMED).map(of).collect();
            write!(f, ". Without {them} these coefficients change by more than their intervals: ")?;
            write!(f, "{}{more}", listed(moved))?;
        } else if !self.coefficients.is_empty() {
            write!(f, ". Without {them} every coefficient stays within its interval")?;
        }
        write!(f, ". Check the part and the probe there, and fit again without {them} (`exclude`)")?;
        if count >= HEAVY_TAILS {
            write!(f, ", or the errors have heavy tails: compare `m_estimator`")?;
        }
        Ok(())
    }
}
