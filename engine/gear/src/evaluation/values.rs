//! What a trace is evaluated to: figures, and the places that stand out of it.

/// Fewest defined samples of the evaluation range.
pub const FEWEST_SAMPLES: usize = 5;
/// Samples this near to the end of a range belong to it, mm: positions are rounded numbers.
pub const EDGE: f64 = 1e-6;

/// The figures of a trace, µm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Values {
    /// f_H, in the sign asked for.
    pub slope: f64,
    /// Standard error of the slope, from the noise of the samples and from what gaps between them
    /// may hide; none where they are too few to tell it.
    pub slope_std_error: Option<f64>,
    /// f_f.
    pub form: f64,
    /// F.
    pub total: f64,
    /// C.
    pub crowning: f64,
    /// Standard error of the crowning; none where the samples are too few to tell it.
    pub crowning_std_error: Option<f64>,
    /// f_Ko of a profile: the mean line of the tip relief at its tip end, above the extended mean
    /// line of the evaluation range; negative where material is missing. `None` where no place of
    /// the relief is given, or where the samples do not cover it.
    pub tip_relief: Option<f64>,
    /// Degrees of freedom of the noise that the standard errors are made of; none where there are
    /// none of them.
    pub freedom: Option<f64>,
    /// The mean line at both ends of the evaluation range, about the design, in the sign and
    /// direction in which the deviations were given.
    pub line: [f64; 2],
    /// The mean parabola at its start, in its middle and at its end, likewise.
    pub parabola: [f64; 3],
    /// By how much plus material outside the evaluation range raised the form and the total
    /// deviation; 0 where the rule leaves it out.
    pub form_plus_material: f64,
    /// The same for the total deviation.
    pub total_plus_material: f64,
}

/// Which figures of a trace may have a class.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Assessable {
    /// No class, and no figure either.
    Nothing,
    /// No class, though there are figures: the samples do not reach both ends of the range.
    Figures,
    /// The slope only, where two standard errors up and down have one class: over a hole a form may
    /// be anything.
    Slope,
    /// All classes and figures.
    Everything,
}

/// A place that stands out of its neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Suspect {
    /// Roll lengths or z of its first and last sample, mm.
    pub from: f64,
    /// Roll length or z of its last sample, mm.
    pub to: f64,
    /// Samples in it.
    pub samples: usize,
    /// How far it stands out at most, µm of material.
    pub height: f64,
    /// Whether it stands out at an end where most other traces of the flank do not.
    pub burr: bool,
}

/// Places that stand out of their neighbours, within what is looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct Suspects {
    /// In ascending order.
    pub places: Vec<Suspect>,
    /// The figures without them, where they count and the samples that are left tell them.
    pub without: Option<Values>,
}
