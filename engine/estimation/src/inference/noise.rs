//! Estimate of the noise.

use flankfit_numerics::distribution::Student;

/// σ of a height of weight 1, how well it is known, and the level of intervals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// σ, or σ̂.
    pub sigma: f64,
    /// The distribution of an error over its standard error.
    pub student: Student,
    /// 1 − level: the probability of an interval to miss.
    pub miss: f64,
}

impl Noise {
    /// σ̂ of residuals with `freedom` degrees of freedom.
    pub fn estimated(sigma: f64, freedom: f64, level: f64) -> Self {
        Noise { sigma, student: Student::new(freedom), miss: 1.0 - level }
    }

    /// σ that was given.
    pub fn known(sigma: f64, level: f64) -> Self {
        Noise { sigma, student: Student::NORMAL, miss: 1.0 - level }
    }

    /// Half the width of an unbiased interval, in standard errors.
    pub fn quantile(&self) -> f64 {
        self.student.upper_quantile(0.5 * self.miss)
    }

    /// The same of a limit on one side.
    pub fn one_sided(&self) -> f64 {
        self.student.upper_quantile(self.miss)
    }
}
