//! Pose of the measured part: an exact rigid motion with six numbers.
//!
//! A point of the nominal flank is first turned by φ about the gear's own axis and moved by c along
//! it; then the axis is turned about the pivot (0, 0, p) by the rotation vector w = (w_x, w_y, 0)
//! and moved by t = (t_x, t_y, 0):
//!
//! `Q = R(w) (R_z(φ) P + (c − p) e_z) + p e_z + t`.
//!
//! In this order rotation and axial shift stay motions along the helicoid's own axis whatever the
//! other four are. For small motions every order comes to the same.

use nalgebra::Matrix3;

use crate::deviation::foot::turned;
use flankfit_geometry::space::Vector;

/// A degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum Motion {
    /// t_x, µm: towards the viewer's right.
    XShift,
    /// t_y, µm: up.
    YShift,
    /// c, µm.
    AxialShift,
    /// w_x, µrad.
    XTilt,
    /// w_y, µrad.
    YTilt,
    /// φ, µrad, counterclockwise.
    Rotation,
}

impl Motion {
    /// All six.
    pub const ALL: [Motion; 6] =
        [Motion::XShift, Motion::YShift, Motion::AxialShift, Motion::XTilt, Motion::YTilt, Motion::Rotation];

    /// Name in requests, responses and sentences.
    pub fn name(self) -> &'static str {
        match self {
            Motion::XShift => "x_shift",
            Motion::YShift => "y_shift",
            Motion::AxialShift => "axial_shift",
            Motion::XTilt => "x_tilt",
            Motion::YTilt => "y_tilt",
            Motion::Rotation => "rotation",
        }
    }

    /// The motion of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|motion| motion.name() == name)
    }

    /// Whether its unit is µrad, not µm.
    pub fn is_angle(self) -> bool {
        matches!(self, Motion::XTilt | Motion::YTilt | Motion::Rotation)
    }
}

/// The position of the measured part: µm and µrad, the pivot in mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// In the order of [`Motion::ALL`].
    pub values: [f64; 6],
    /// z of the point about which the axis tilts, mm.
    pub pivot: f64,
}

impl Pose {
    /// How far a tilt may go, rad.
    pub const MOST_TILT: f64 = 0.1;

    /// µm or µrad.
    pub fn get(&self, motion: Motion) -> f64 {
        self.values[motion as usize]
    }

    /// Sets a motion, µm or µrad.
    pub fn set(&mut self, motion: Motion, value: f64) {
        self.values[motion as usize] = value;
    }

    /// mm or rad.
    fn plain(&self, motion: Motion) -> f64 {
        self.get(motion) * if motion.is_angle() { 1e-6 } else { 1e-3 }
    }

    /// Returns true for a motion that a registration can have.
    pub fn is_sane(&self) -> bool {
        self.values.iter().all(|x| x.is_finite()) && self.tilt().norm() <= Self::MOST_TILT
    }

    fn tilt(&self) -> Vector {
        Vector::new(self.plain(Motion::XTilt), self.plain(Motion::YTilt), 0.0)
    }

    fn shift(&self) -> Vector {
        Vector::new(self.plain(Motion::XShift), self.plain(Motion::YShift), 0.0)
    }

    /// Returns the place of a point of the nominal part, mm.
    pub fn apply(&self, point: &Vector) -> Vector {
        let about = Vector::new(0.0, 0.0, self.plain(Motion::AxialShift) - self.pivot);
        let own = turned(*point, self.plain(Motion::Rotation)) + about;
        rotation(&self.tilt()) * own + self.shift() + self.pivot * Vector::z()
    }

    /// The same motion about another pivot, but for the square of the tilts along the axis.
    pub fn about(&self, pivot: f64) -> Self {
        let moved = (rotation(&self.tilt()) - Matrix3::identity()) * Vector::new(0.0, 0.0, pivot - self.pivot);
        let mut values = self.values;
        values[Motion::XShift as usize] += 1e3 * moved.x;
        values[Motion::YShift as usize] += 1e3 * moved.y;
        Pose { values, pivot }
    }

    /// The motion ready to be undone at many points.
    pub fn undoing(&self) -> InversePose {
        let tilt = self.tilt();
        let rotation = rotation(&tilt);
        InversePose {
            rotation,
            inverse: rotation.transpose(),
            jacobian: right_jacobian(&tilt),
            origin: self.shift() + self.pivot * Vector::z(),
            along: self.pivot - self.plain(Motion::AxialShift),
            turn: self.plain(Motion::Rotation),
        }
    }
}

/// The inverse of a pose with its derivatives.
#[derive(Clone, Copy, Debug)]
pub struct InversePose {
    rotation: Matrix3<f64>,
    inverse: Matrix3<f64>,
    jacobian: Matrix3<f64>,
    origin: Vector,
    along: f64,
    turn: f64,
}

impl InversePose {
    /// Returns the place of a measured point on the nominal part, mm.
    pub fn point(&self, measured: &Vector) -> Vector {
        turned(self.relative_to_pivot(measured) + self.along * Vector::z(), -self.turn)
    }

    /// Returns a direction of the measured part as one of the nominal part.
    pub fn direction(&self, measured: &Vector) -> Vector {
        turned(self.inverse * measured, -self.turn)
    }

    fn relative_to_pivot(&self, measured: &Vector) -> Vector {
        self.inverse * (measured - self.origin)
    }

    /// How much the normal distance of a measured point grows per unit of the shifts (µm per µm)
    /// and of the tilts (µm per µrad) of the part; `normal` is the one at its foot on the nominal
    /// part. The order is x and y shift, x and y tilt.
    pub fn columns(&self, measured: &Vector, normal: &Vector) -> [f64; 4] {
        let relative = self.relative_to_pivot(measured);
        let normal = turned(*normal, self.turn);
        let shifted = self.rotation * normal;
        // d(Rᵀq) = −(J dw) × Rᵀq; the part moves the other way than the point that is carried back
        let arm = self.jacobian.transpose() * relative.cross(&normal);
        [shifted.x, shifted.y, 1e-3 * arm.x, 1e-3 * arm.y]
    }
}

/// [w]: [w] v = w × v.
fn cross_matrix(w: &Vector) -> Matrix3<f64> {
    w.cross_matrix()
}

/// (sin θ)/θ.
fn sinc(angle: f64) -> f64 {
    if angle.abs() < 1e-4 { 1.0 - angle * angle / 6.0 } else { angle.sin() / angle }
}

/// Rodrigues: R(w) = 1 + (sin θ/θ) [w] + ((1 − cos θ)/θ²) [w]².
fn rotation(w: &Vector) -> Matrix3<f64> {
    let (angle, cross) = (w.norm(), cross_matrix(w));
    Matrix3::identity() + cross * sinc(angle) + cross * cross * (0.5 * sinc(0.5 * angle).powi(2))
}

/// R(w + dw) = R(w) R(J dw): J = 1 − ((1 − cos θ)/θ²) [w] + ((θ − sin θ)/θ³) [w]².
fn right_jacobian(w: &Vector) -> Matrix3<f64> {
    let (angle, cross) = (w.norm(), cross_matrix(w));
    let square = angle * angle;
    let third = if angle < 0.1 {
        1.0 / 6.0 - square * (1.0 / 120.0 - square * (1.0 / 5040.0 - square / 362_880.0))
    } else {
        (angle - angle.sin()) / (square * angle)
    };
    Matrix3::identity() - cross * (0.5 * sinc(0.5 * angle).powi(2)) + cross * cross * third
}
