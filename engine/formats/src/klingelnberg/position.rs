//! Traces with positions: what the evaluation takes.

use super::{Block, Curve, Curves, HelixSetup, ProfileAxis, ProfileSetup, Section, Sides, SignConvention, Signs};
use flankfit_gear::{Gear, Kind, Side, Trace};
use flankfit_numerics::words::Shown;

/// A trace whose samples have positions.
#[derive(Clone, Debug, PartialEq)]
pub struct PositionedTrace {
    /// Deviations with the sign stored.
    pub trace: Trace,
    /// Block of the file that the trace belongs to.
    pub block: Block,
    /// Number within its group.
    pub index: Option<u32>,
    /// Number of undefined samples.
    pub undefined: usize,
    /// Line of its head in the file.
    pub line: usize,
}

/// A trace that could not be placed: nothing of a file is left out without a word.
#[derive(Clone, Debug, PartialEq)]
pub struct UnpositionedTrace {
    /// The tooth as the file names it.
    pub tooth: String,
    /// Flank of the tooth.
    pub side: Side,
    /// Profile or helix.
    pub kind: Kind,
    /// Line in the file, from 1.
    pub line: usize,
    /// Reason why it has no positions.
    pub why: String,
}

/// All traces of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct PositionedTraces {
    /// Traces with positions, in the order of the file.
    pub traces: Vec<PositionedTrace>,
    /// Traces without positions.
    pub unplaced: Vec<UnpositionedTrace>,
}

impl Curves {
    /// Gives every sample its position: roll length for profiles (equal steps of roll length from
    /// start to end of the measuring range), z for leads; section z or diameter. Deviations keep
    /// the sign stored; see [`PositionedTraces::with_sense`].
    ///
    /// `gear` is the one that was measured, from [`Header::gear`](super::Header::gear) or known
    /// otherwise.
    pub fn place(&self, gear: &Gear) -> PositionedTraces {
        let header = &self.header;
        let site = Site { gear, profile: header.profile_setup(), helix: header.helix_setup() };
        let mut placed = PositionedTraces { traces: Vec::with_capacity(self.curves.len()), unplaced: Vec::new() };
        for curve in &self.curves {
            match site.place(curve) {
                Ok(trace) => placed.traces.push(trace),
                Err(why) => placed.unplaced.push(UnpositionedTrace {
                    tooth: curve.tooth.clone(),
                    side: curve.side,
                    kind: curve.kind,
                    line: curve.line,
                    why,
                }),
            }
        }
        placed
    }

    /// Factors for the stored signs by this file's settings.
    pub fn signs(&self) -> Signs {
        Signs::of(&self.header.rules())
    }
}

impl PositionedTraces {
    /// Turns every stored deviation into one sense.
    pub fn with_sense(mut self, signs: Signs, sense: SignConvention) -> Self {
        for placed in &mut self.traces {
            let factor = signs.factor(sense, placed.trace.kind, placed.trace.side);
            for value in &mut placed.trace.deviation {
                *value *= factor;
            }
        }
        self
    }
}

struct Site<'a> {
    gear: &'a Gear,
    profile: ProfileSetup,
    helix: HelixSetup,
}

impl Site<'_> {
    fn place(&self, curve: &Curve) -> Result<PositionedTrace, String> {
        let (start, end) = match curve.kind {
            Kind::Profile => {
                let range = self.profile.measured.of(curve.side).ok_or_else(|| no_range([41, 44]))?;
                (self.roll_length(range.start)?, self.roll_length(range.end)?)
            }
            Kind::Helix => {
                let range = self.helix.measured.of(curve.side).ok_or_else(|| no_range([61, 64]))?;
                (range.start, range.end)
            }
        };
        let count = curve.values.len();
        if start == end && count > 1 {
            let start = Shown(start);
            return Err(format!("the measuring range has no length: it starts and ends at {start}"));
        }
        let steps = count.saturating_sub(1).max(1) as f64;
        let at =
            (0..count).map(|i| if i + 1 == count && i > 0 { end } else { start + (end - start) * (i as f64 / steps) });
        Ok(PositionedTrace {
            trace: Trace {
                tooth: curve.tooth.clone(),
                side: curve.side,
                kind: curve.kind,
                at: at.collect(),
                section: self.section(curve),
                deviation: curve.values.clone(),
            },
            block: curve.block.clone(),
            index: curve.index,
            undefined: curve.undefined,
            line: curve.line,
        })
    }

    /// Roll length of a place on the profile, mm.
    fn roll_length(&self, place: f64) -> Result<f64, String> {
        let base = 2.0 * self.gear.base_radius();
        match &self.profile.axis {
            ProfileAxis::Diameter => self.gear.roll_length(place).ok_or_else(|| {
                let [place, base] = [place, base].map(Shown);
                format!("the measuring range reaches {place} mm, which is below the base circle of {base} mm")
            }),
            ProfileAxis::RollLength => Ok(place),
            ProfileAxis::RollAngle => Ok(self.gear.base_radius() * place.to_radians()),
            ProfileAxis::Unknown(word) => {
                Err(format!("profile places are given in “{word}”, which has no known meaning"))
            }
        }
    }

    /// z of a profile, diameter of a lead.
    fn section(&self, curve: &Curve) -> Option<f64> {
        match (curve.kind, curve.section) {
            (Kind::Profile, Section::Z(z)) => Some(z),
            (Kind::Profile, _) => *self.profile.middle.of(curve.side),
            (Kind::Helix, Section::Diameter(diameter)) => Some(diameter),
            (Kind::Helix, Section::RollLength(roll)) => Some(self.diameter(roll, curve.side)),
            (Kind::Helix, _) => *self.helix.middle.of(curve.side),
        }
    }

    /// The diameter at a roll length of three decimals: the header's circle that it was rounded
    /// from, if it is one of them.
    fn diameter(&self, roll: f64, side: Side) -> f64 {
        let circles: [&Sides<Option<f64>>; 3] = [&self.helix.middle, &self.helix.inner, &self.helix.outer];
        let near =
            |diameter: &f64| self.gear.roll_length(*diameter).is_some_and(|exact| (exact - roll).abs() <= 0.00051);
        circles.into_iter().filter_map(|circle| *circle.of(side)).find(near).unwrap_or_else(|| self.gear.diameter(roll))
    }
}

/// The message of a header without a measuring range.
fn no_range([from, to]: [u32; 2]) -> String {
    format!("the header has no measuring range (codes {from} and {to})")
}
