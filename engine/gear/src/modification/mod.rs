//! Intended deviations from the involute helicoid: the vector function |Δk(r, b)| along the nominal
//! normal.
//!
//! **Sign.** Every amount is a *relief* in µm: positive is material removed, against the normal; a
//! flank made exactly so deviates by −relief from the unmodified nominal. Modifications superpose
//! by addition.
//!
//! **Range.** All of them refer to one explicit [`Range`]: profile from its root end to its tip
//! end, as roll lengths, and face width from the end of lower z to the end of higher z. With u and
//! v running from −1 to +1 over it (u from root to tip, on internal gears too):
//!
//! | modification | relief |
//! |---|---|
//! | profile crowning C_α | C u²: 0 in the middle, C at both ends |
//! | profile slope C_Hα | C u/2: relief at the tip end less that at the root end; the middle stays |
//! | tip relief C_αa, root relief C_αf | from 0 at its start to C at the end of the range, t or t² in roll length |
//! | helix crowning C_β | C v² |
//! | helix slope C_Hβ | C v/2: relief at the end of higher z less that at the end of lower z |
//! | end relief C_βI, C_βII | from 0 at `length` inside the end of lower (I) or higher (II) z to C at that end, t or t² |
//! | twist S | S u v/4: the profile slope at the end of higher z less that at the end of lower z |
//! | topography | values on a grid, interpolated bilinearly or by a bicubic B-spline, constant outside the grid's border |
//!
//! Beyond the range the formulas go on (a relief keeps its law up to the nominal tip).
//!
//! **Normals.** A modified flank is the surface P − relief · n. Its normal is not n: [`Relief`]
//! carries the slopes, and the node grid returns the true normal of the modified surface. Where a
//! linear relief starts, the side of the relief counts.

pub mod law;
pub mod range;
mod relief;
pub mod topography;

pub use law::{End, Growth, Law};
pub use range::Range;
pub use relief::Relief;
pub use topography::{Interpolation, Topography};

use super::{Gear, Side};
use flankfit_numerics::check::Faults;
use law::AnalyticLaw;
use topography::{Columns, Contracted};

/// Most modifications of one flank.
pub const MOST: usize = 100;
/// Shortest length on a flank, mm: a relief over less would be a step with infinite
/// slopes.
pub const LEAST_LENGTH: f64 = 1e-6;

/// Flanks of a modification. Default `both`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = ModifiedFlanks)
)]
pub enum Flanks {
    /// Left flanks alone.
    Left,
    /// Right flanks alone.
    Right,
    /// Both flanks.
    #[default]
    Both,
}

impl Flanks {
    /// Whether `side` is among them.
    pub fn has(self, side: Side) -> bool {
        matches!((self, side), (Flanks::Both, _) | (Flanks::Left, Side::Left) | (Flanks::Right, Side::Right))
    }
}

/// One modification.
#[derive(Clone, Debug, PartialEq)]
pub struct Modification {
    /// Flanks that it is meant for.
    pub flanks: Flanks,
    /// Law of the relief.
    pub law: Law,
}

/// Checked modifications, superposed over one range.
#[derive(Clone, Debug, PartialEq)]
pub struct Modifications {
    range: Range,
    parts: Vec<(Flanks, AnalyticLaw)>,
    topographies: Vec<(Flanks, Topography)>,
}

impl Modifications {
    /// Checks every modification of the list.
    pub fn new(gear: &Gear, range: Range, list: Vec<Modification>) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        if list.len() > MOST {
            faults.push("", format_args!("{} modifications; at most {MOST} are superposed", list.len()));
            return Err(faults);
        }
        let mut made = Modifications { range, parts: Vec::new(), topographies: Vec::new() };
        for (number, modification) in list.into_iter().enumerate() {
            match modification.law {
                Law::Topography(topography) => made.topographies.push((modification.flanks, topography)),
                law => match AnalyticLaw::new(gear, &range, &law) {
                    Ok(part) => made.parts.push((modification.flanks, part)),
                    Err(found) => faults.append(found.within(&format!("[{number}]"))),
                },
            }
        }
        faults.into_result(made)
    }

    /// Whether `side` is left as it is.
    pub fn is_none_on(&self, side: Side) -> bool {
        !self.parts.iter().any(|(flanks, _)| flanks.has(side))
            && !self.topographies.iter().any(|(flanks, _)| flanks.has(side))
    }

    /// The relief at one place, both coordinates in mm.
    ///
    /// ```
    /// use flankfit_gear::{
    ///     Gear, GearData, Modifications, Side,
    ///     modification::{Flanks, Law, Modification, Range},
    /// };
    ///
    /// // 6 µm of helix crowning: nothing in the middle of the face, all of it at both ends.
    /// let gear = Gear::new(GearData { face_width: Some(20.0), ..GearData::spur(52, 1.0) })?;
    /// let range = Range::new(&gear, [50.5, 53.5], [0.0, 20.0])?;
    /// let law = Law::HelixCrowning { amount: 6.0 };
    /// let crowned = Modification { flanks: Flanks::Both, law };
    /// let modifications = Modifications::new(&gear, range, vec![crowned])?;
    /// let relief = |z: f64| modifications.relief(Side::Left, 9.0, z).value;
    /// assert_eq!([relief(0.0), relief(10.0), relief(20.0)], [6.0, 0.0, 6.0]);
    /// assert_eq!(relief(5.0), 1.5); // a parabola: a quarter half-way
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn relief(&self, side: Side, roll_length: f64, z: f64) -> Relief {
        self.row(side, roll_length).at(&self.column(side, z))
    }

    /// Part that depends on the roll length alone, for many places of one profile.
    pub fn row(&self, side: Side, roll_length: f64) -> Row {
        let mut row = Row { u: self.range.u(roll_length), u_slope: self.range.u_slope(), ..Row::default() };
        for (_, part) in self.parts.iter().filter(|(flanks, _)| flanks.has(side)) {
            let (value, slope) = part.along_profile(&self.range, roll_length);
            row.value += value;
            row.slope += slope;
            row.twist += part.twist();
        }
        row.topographies = self.topographies_of(side).map(|topography| topography.contracted(roll_length)).collect();
        row
    }

    /// Part that depends on z alone, for many places of one section.
    pub fn column(&self, side: Side, z: f64) -> Column {
        let mut column = Column { v: self.range.v(z), v_slope: self.range.v_slope(), ..Column::default() };
        for (_, part) in self.parts.iter().filter(|(flanks, _)| flanks.has(side)) {
            let (value, slope) = part.along_helix(&self.range, z);
            column.value += value;
            column.slope += slope;
        }
        column.topographies = self.topographies_of(side).map(|topography| topography.columns(z)).collect();
        column
    }

    fn topographies_of(&self, side: Side) -> impl Iterator<Item = &Topography> {
        self.topographies.iter().filter(move |(flanks, _)| flanks.has(side)).map(|(_, topography)| topography)
    }
}

/// One profile of a modified flank.
#[derive(Clone, Debug, Default)]
pub struct Row {
    value: f64,
    slope: f64,
    twist: f64,
    u: f64,
    u_slope: f64,
    topographies: Vec<Contracted>,
}

/// One section of a modified flank.
#[derive(Clone, Debug, Default)]
pub struct Column {
    value: f64,
    slope: f64,
    v: f64,
    v_slope: f64,
    topographies: Vec<Columns>,
}

impl Row {
    /// The relief where this profile meets a section of the same flank and the same modifications.
    pub fn at(&self, column: &Column) -> Relief {
        let quarter = 0.25 * self.twist;
        let mut relief = Relief {
            value: self.value + column.value + quarter * self.u * column.v,
            by_roll: self.slope + quarter * self.u_slope * column.v,
            by_z: column.slope + quarter * self.u * column.v_slope,
        };
        for (contracted, columns) in self.topographies.iter().zip(&column.topographies) {
            let more = contracted.at(columns);
            relief.value += more.value;
            relief.by_roll += more.by_roll;
            relief.by_z += more.by_z;
        }
        relief
    }
}
