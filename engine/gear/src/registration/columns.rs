//! Columns of the registration: what each motion of the part adds to the deviations.
//!
//! With the normal n and the place Q of a point a shift along e adds n·e and a turn about a axis a
//! adds (Q × n)·a, in µm per µm and µm per µrad. On an involute helicoid two of the six are the
//! same at every point of a side:
//!
//! `n·e_z = −s h sin β_b`, `(Q × n)·e_z = s r_b cos β_b`,
//!
//! with the same sign s in both. So rotation and axial shift are parallel on one flank, on both
//! flanks and on all teeth: a screw motion carries a cylindrical gear's flanks into themselves. The
//! two enter the fit as one column, and all of its coefficient is rotation: a share of it taken as
//! axial shift would carry the points along the flank, and with them the modification. On spur
//! gears the axial shift adds nothing at all.
//!
//! Only a modification that changes along z shows how far the part slid along its own helices: a
//! slide by c adds `c ∂relief/∂z`. Where that is significant it is a column of its own
//! ([`Column::Slide`]).

use super::pose::{Motion, Pose};
use crate::{Gear, Side};
use flankfit_numerics::check::Faults;

/// Name of the column of rotation and axial shift together.
pub const SCREW: &str = "rotation_with_axial_shift";

/// A column of the fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    /// A motion by itself.
    Motion(Motion),
    /// Rotation and axial shift; its coefficient is the normal distance that they add to left
    /// flanks, µm.
    Screw,
    /// Axial shift (µm) with the rotation that keeps the unmodified flanks in themselves.
    Slide,
}

impl Column {
    /// As the fit calls it.
    pub fn name(self) -> &'static str {
        match self {
            Column::Motion(motion) => motion.name(),
            Column::Screw => SCREW,
            Column::Slide => Motion::AxialShift.name(),
        }
    }
}

/// Which motions are free, and how they enter the fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Freedom {
    /// In the order of [`Motion::ALL`].
    pub motions: Vec<Motion>,
    /// Columns of the fit, which may be fewer than the motions.
    pub columns: Vec<Column>,
    /// µm of normal distance on left flanks per µm of axial shift.
    axial: f64,
    /// µm of normal distance on left flanks per µrad of rotation.
    rotation: f64,
}

impl Freedom {
    /// Refuses none, a motion that is listed twice, and what no point can determine.
    pub fn new(gear: &Gear, asked: &[Motion]) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        if asked.is_empty() {
            faults.push("registration.motions", "no motion is free");
        }
        for (index, motion) in asked.iter().enumerate() {
            if asked[..index].contains(motion) {
                faults.push(
                    format_args!("registration.motions[{index}]"),
                    format_args!("`{}` occurs twice; give it once", motion.name()),
                );
            }
        }
        let (sin_b, cos_b) = gear.base_helix_angle().sin_cos();
        // + 0 makes no difference between left- and right-handed spur gears
        let (axial, rotation) = (0.0 - gear.hand() * sin_b, 1e-3 * gear.base_radius() * cos_b);
        if axial == 0.0 && asked == [Motion::AxialShift] {
            faults.push(
                "registration.motions[0]",
                "the flanks of a spur gear are the same along the axis: no point determines an axial shift",
            );
        }
        faults.into_result(())?;
        let motions: Vec<Motion> = Motion::ALL.into_iter().filter(|motion| asked.contains(motion)).collect();
        let both = motions.contains(&Motion::AxialShift) && motions.contains(&Motion::Rotation);
        let columns = motions
            .iter()
            .filter(|motion| match motion {
                Motion::AxialShift => !both && axial != 0.0,
                _ => true,
            })
            .map(|motion| match motion {
                Motion::Rotation if both && axial != 0.0 => Column::Screw,
                motion => Column::Motion(*motion),
            })
            .collect();
        Ok(Freedom { motions, columns, axial, rotation })
    }

    /// Whether the fit has a column for every motion.
    pub fn is_whole(&self) -> bool {
        self.columns.len() == self.motions.len()
    }

    /// The column that turns the part about its own axis or screws it along, and its unit of
    /// rotation: what coefficient goes with 1 rad.
    pub fn screw(&self, gear: &Gear) -> Option<(usize, f64)> {
        // µm of normal distance on left flanks
        let along = 1e3 * gear.base_radius() * gear.base_helix_angle().cos();
        self.columns.iter().enumerate().find_map(|(k, column)| match column {
            Column::Screw => Some((k, along)),
            Column::Motion(Motion::Rotation) => Some((k, along / self.rotation)),
            Column::Motion(Motion::AxialShift) => Some((k, along / self.axial)),
            Column::Motion(_) | Column::Slide => None,
        })
    }

    /// The same motions with a column for the slide along the helices.
    pub fn with_slide(&self) -> Self {
        let mut with = self.clone();
        with.columns.push(Column::Slide);
        with
    }

    /// One entry of a row: `other` are those of [`super::pose::InversePose::columns`], `slope` is
    /// that of the relief along z, µm per µm.
    pub fn entry(&self, column: Column, side: Side, other: &[f64; 4], slope: f64) -> f64 {
        match column {
            Column::Screw => side.sign(),
            Column::Slide => slope,
            Column::Motion(Motion::XShift) => other[0],
            Column::Motion(Motion::YShift) => other[1],
            Column::Motion(Motion::XTilt) => other[2],
            Column::Motion(Motion::YTilt) => other[3],
            Column::Motion(Motion::AxialShift) => side.sign() * self.axial,
            Column::Motion(Motion::Rotation) => side.sign() * self.rotation,
        }
    }

    /// The motions that a column moves, and how much of each per unit of its coefficient.
    pub fn shares(&self, column: Column) -> Vec<(Motion, f64)> {
        match column {
            Column::Motion(motion) => vec![(motion, 1.0)],
            Column::Screw => vec![(Motion::Rotation, 1.0 / self.rotation)],
            Column::Slide if self.columns.contains(&Column::Screw) => {
                vec![(Motion::AxialShift, 1.0), (Motion::Rotation, -self.axial / self.rotation)]
            }
            Column::Slide => vec![(Motion::AxialShift, 1.0)],
        }
    }

    /// Sets the motions of a pose that coefficients of the columns stand for.
    pub fn set(&self, pose: &mut Pose, coefficients: &[f64]) {
        for motion in &self.motions {
            pose.set(*motion, 0.0);
        }
        for (column, value) in self.columns.iter().zip(coefficients) {
            for (motion, share) in self.shares(*column) {
                pose.set(motion, pose.get(motion) + share * value);
            }
        }
    }

    /// The coefficients of the columns that stand for a pose, as far as there are any.
    pub fn coefficients(&self, pose: &Pose) -> Vec<f64> {
        let each = self.columns.iter();
        each.map(|column| match column {
            Column::Motion(motion) => pose.get(*motion),
            Column::Screw => self.axial * pose.get(Motion::AxialShift) + self.rotation * pose.get(Motion::Rotation),
            Column::Slide => pose.get(Motion::AxialShift),
        })
        .collect()
    }

    /// Whether points can tell a motion from all others.
    pub fn determines(&self, motion: Motion) -> bool {
        let slid = self.columns.contains(&Column::Slide) && matches!(motion, Motion::AxialShift | Motion::Rotation);
        slid || self.columns.contains(&Column::Motion(motion))
    }
}
