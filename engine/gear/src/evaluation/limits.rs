//! Limits that figures of a flank must lie within, and what is inferred of a figure.

use crate::{
    Gear, Kind, Side,
    tolerance::{COARSEST, Characteristic, FINEST, OutOfScope, Rounding, Tolerances},
};
use flankfit_estimation::{inference::Inferred, result::IntervalKind};
use flankfit_numerics::{check::Faults, words::Shown};

/// Declares limits of gear figures, with further members before them.
macro_rules! limits {
    ($(#[$meta:meta])* $name:ident { $($(#[$more_meta:meta])* $more:ident: $of:ty,)* }) => {
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        #[cfg_attr(
            feature = "contract",
            serde_with_macros::skip_serializing_none,
            derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
            serde(deny_unknown_fields)
        )]
        $(#[$meta])*
        pub struct $name {
            $($(#[$more_meta])* pub $more: Option<$of>,)*
            /// Limits of f_Hα over the reference length (of surfaces: the evaluation range).
            #[cfg_attr(feature = "contract", schema(min_items = 2, max_items = 2))]
            pub profile_slope_um: Option<[f64; 2]>,
            /// Limits of f_Hβ over the reference length (of surfaces: the face width).
            #[cfg_attr(feature = "contract", schema(min_items = 2, max_items = 2))]
            pub helix_slope_um: Option<[f64; 2]>,
            /// Limits of C_α.
            #[cfg_attr(feature = "contract", schema(min_items = 2, max_items = 2))]
            pub profile_crowning_um: Option<[f64; 2]>,
            /// Limits of C_β.
            #[cfg_attr(feature = "contract", schema(min_items = 2, max_items = 2))]
            pub helix_crowning_um: Option<[f64; 2]>,
            /// Limits of the twist of surfaces.
            #[cfg_attr(feature = "contract", schema(min_items = 2, max_items = 2))]
            pub twist_um: Option<[f64; 2]>,
            /// Limits of f_fα of traces.
            #[cfg_attr(feature = "contract", schema(min_items = 2, max_items = 2))]
            pub profile_form_um: Option<[f64; 2]>,
            /// Limits of f_fβ of traces.
            #[cfg_attr(feature = "contract", schema(min_items = 2, max_items = 2))]
            pub helix_form_um: Option<[f64; 2]>,
            /// Limits of F_α of traces.
            #[cfg_attr(feature = "contract", schema(min_items = 2, max_items = 2))]
            pub profile_total_um: Option<[f64; 2]>,
            /// Limits of F_β of traces.
            #[cfg_attr(feature = "contract", schema(min_items = 2, max_items = 2))]
            pub helix_total_um: Option<[f64; 2]>,
        }

        impl $name {
            /// Returns the limits with their names.
            fn named(&self) -> [(&'static str, Option<[f64; 2]>); 9] {
                [
                    ("profile_slope_um", self.profile_slope_um),
                    ("helix_slope_um", self.helix_slope_um),
                    ("profile_crowning_um", self.profile_crowning_um),
                    ("helix_crowning_um", self.helix_crowning_um),
                    ("twist_um", self.twist_um),
                    ("profile_form_um", self.profile_form_um),
                    ("helix_form_um", self.helix_form_um),
                    ("profile_total_um", self.profile_total_um),
                    ("helix_total_um", self.helix_total_um),
                ]
            }

            /// Leaves out limits of slopes, crownings and twist, which are of the flank and not of
            /// its distance from the design.
            fn without_shapes(self) -> Self {
                $name {
                    profile_slope_um: None,
                    helix_slope_um: None,
                    profile_crowning_um: None,
                    helix_crowning_um: None,
                    twist_um: None,
                    ..self
                }
            }

            /// Refuses limits that do not ascend.
            fn check_order(&self) -> Faults {
                ascending(&self.named())
            }

            /// Refuses limits of form and total deviations.
            fn check_of_traces(&self) -> Faults {
                let mut faults = Faults::default();
                for (name, limits) in &self.named()[5..] {
                    if limits.is_some() {
                        let message = "limits of form and total deviations apply to traces only; omit them, or \
                            evaluate traces";
                        faults.push(name, message);
                    }
                }
                faults
            }
        }
    };
}

limits! {
    /// Limits of the figures of one flank, `[low, high]` in µm and in the sign of the response.
    #[cfg_attr(feature = "contract", schema(as = FlankLimits))]
    ToleranceLimits {
        /// The class of ISO 1328-1 whose tolerances limit slopes, forms and totals without limits.
        #[cfg_attr(feature = "contract", serde(skip))]
        class: u8,
    }
}

limits! {
    /// Limits of figures, `[low, high]` in µm, in the sign and the direction of the response. Each
    /// figure that has limits is returned with `within` and its conformity.
    #[cfg_attr(feature = "contract", schema(as = ToleranceLimits))]
    SidedLimits {
        /// Class 1 to 11 of ISO 1328-1:2013: its tolerances limit the slopes, and of traces the
        /// forms and totals, without limits here (the standard has none of crownings and twist).
        #[cfg_attr(feature = "contract", schema(minimum = 1, maximum = 11))]
        class: u8,
        /// Limits of left flanks, which replace those for both.
        left: ToleranceLimits,
        /// Limits of right flanks, likewise.
        right: ToleranceLimits,
    }
}

impl From<ToleranceLimits> for SidedLimits {
    /// The same of both flanks.
    fn from(limits: ToleranceLimits) -> Self {
        SidedLimits { class: limits.class, left: Some(limits), right: Some(limits), ..SidedLimits::default() }
    }
}

impl SidedLimits {
    /// Returns the limits of a flank.
    pub fn of(&self, side: Side) -> ToleranceLimits {
        let own = self.own(side).unwrap_or_default().named();
        let both = self.named();
        let [
            profile_slope_um,
            helix_slope_um,
            profile_crowning_um,
            helix_crowning_um,
            twist_um,
            profile_form_um,
            helix_form_um,
            profile_total_um,
            helix_total_um,
        ] = std::array::from_fn(|k| own[k].1.or(both[k].1));
        ToleranceLimits {
            class: self.class,
            profile_slope_um,
            helix_slope_um,
            profile_crowning_um,
            helix_crowning_um,
            twist_um,
            profile_form_um,
            helix_form_um,
            profile_total_um,
            helix_total_um,
        }
    }

    fn own(&self, side: Side) -> Option<ToleranceLimits> {
        match side {
            Side::Left => self.left,
            Side::Right => self.right,
        }
    }

    /// Returns the limits of figures about the design.
    #[must_use]
    pub fn about_design(self) -> Self {
        let [left, right] = [self.left, self.right].map(|own| own.map(ToleranceLimits::without_shapes));
        SidedLimits { left, right, ..self.without_shapes() }
    }

    /// Refuses limits that are impossible on any gear.
    pub fn check(&self) -> Faults {
        let mut faults = Faults::default();
        if let Some(message) = self.class.and_then(no_class) {
            faults.push("class", message);
        }
        self.check_each(faults, Self::check_order, ToleranceLimits::check_order)
    }

    /// Refuses limits of form and total deviations, which only traces have.
    pub fn check_for_surface(&self) -> Faults {
        self.check_each(Faults::default(), Self::check_of_traces, ToleranceLimits::check_of_traces)
    }

    fn check_each(
        &self,
        mut faults: Faults,
        both: impl Fn(&Self) -> Faults,
        own: impl Fn(&ToleranceLimits) -> Faults,
    ) -> Faults {
        faults.append(both(self));
        for (name, limits) in [("left", self.left), ("right", self.right)] {
            faults.append(limits.map_or_else(Faults::default, |limits| own(&limits).within(name)));
        }
        faults
    }

    /// Refuses limits that are impossible on a gear, each error once.
    pub(super) fn check_on(&self, tolerances: &Result<Tolerances, OutOfScope>, helix: bool) -> Faults {
        let faults = self.check();
        let class = [Side::Left, Side::Right].map(|side| self.of(side).class_without_limits(tolerances, helix));
        match class.into_iter().flatten().next().filter(|_| faults.is_empty()) {
            Some(message) => Faults::one("class", message),
            None => faults,
        }
    }
}

/// The limits that a trace was held against, µm; `None` where there are none, or where the trace
/// does not tell enough to be held against them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TraceLimits {
    /// Limits of f_H.
    pub slope: Option<[f64; 2]>,
    /// Limits of f_f.
    pub form: Option<[f64; 2]>,
    /// Limits of F.
    pub total: Option<[f64; 2]>,
    /// Limits of C.
    pub crowning: Option<[f64; 2]>,
}

/// Whether a figure lies within its limits, as it was estimated.
pub fn within(value: f64, limits: Option<[f64; 2]>) -> Option<bool> {
    limits.map(|[low, high]| low <= value && value <= high)
}

/// A figure's confidence interval.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct Inference {
    /// Confidence interval of the true figure at `level`, `[low, high]`: of a regularised surface
    /// about least squares, unless a norm limit was given. Absent if `std_error` is.
    pub interval: [f64; 2],
    /// Basis of the interval.
    #[cfg_attr(feature = "contract", serde(rename = "interval_kind"))]
    pub kind: IntervalKind,
    /// The estimate that the interval is of.
    #[cfg_attr(feature = "contract", serde(skip))]
    pub about: Inferred,
    /// Degrees of freedom of Student's distribution for the interval; absent if the noise is known.
    pub degrees_of_freedom: Option<f64>,
}

impl Inference {
    /// Infers an unbiased figure.
    pub(super) fn new(about: &Inferred, level: f64) -> Self {
        Inference::with(about.interval(level), IntervalKind::Student, *about)
    }

    pub(super) fn with(interval: [f64; 2], kind: IntervalKind, about: Inferred) -> Self {
        let degrees_of_freedom = Some(about.student.freedom()).filter(|freedom| freedom.is_finite());
        Inference { interval, kind, about, degrees_of_freedom }
    }
}

/// Refuses limits that do not ascend, by their names.
pub(super) fn ascending(named: &[(&'static str, Option<[f64; 2]>)]) -> Faults {
    let mut faults = Faults::default();
    for (name, limits) in named {
        if let Some([low, high]) = limits.filter(|[low, high]| !(low < high)) {
            let [low, high] = [low, high].map(Shown);
            let message = format_args!("{low} to {high} µm is not a range; write the lower limit first");
            faults.push(name, message);
        }
    }
    faults
}

/// The message of a class that there is not, where there is none.
pub(super) fn no_class(class: u8) -> Option<String> {
    let there = (FINEST..=COARSEST).contains(&class);
    (!there).then(|| format!("{class} is not one of {FINEST} to {COARSEST}"))
}

/// The message of a class that gives no tolerances, where one is asked for.
pub(super) fn class_refused(class: Option<u8>, tolerances: &Result<Tolerances, OutOfScope>) -> Option<String> {
    match (no_class(class?), tolerances) {
        (Some(message), _) => Some(message),
        (_, Err(out)) => Some(format!("the class gives no limits: {out}")),
        (_, Ok(_)) => None,
    }
}

impl ToleranceLimits {
    /// Refuses limits that are impossible on a gear; `helix` says that there are slopes of helices.
    pub(super) fn check(&self, tolerances: &Result<Tolerances, OutOfScope>, helix: bool) -> Faults {
        let mut faults = self.check_order();
        if let Some(message) = self.class_without_limits(tolerances, helix) {
            faults.push("class", message);
        }
        faults
    }

    fn class_without_limits(&self, tolerances: &Result<Tolerances, OutOfScope>, helix: bool) -> Option<String> {
        let no_face_width = || {
            let open = helix && self.helix_slope_um.is_none();
            let slope = tolerances.as_ref().ok()?.unrounded(Characteristic::HelixSlope, self.class?);
            let message =
                "the class gives no limits of helix slopes without the face width of the gear; give it, or the limits";
            (open && slope.is_none()).then(|| message.to_owned())
        };
        class_refused(self.class, tolerances).or_else(no_face_width)
    }

    /// The message of a class that gives no limits on this gear, where one is asked for.
    pub fn class_refused(&self, gear: &Gear, helix: bool) -> Option<String> {
        self.class_without_limits(&Tolerances::new(gear), helix)
    }

    /// Returns the limits of a slope over a share of the length that it refers to: those given,
    /// else those of the class. ISO 1328-1 has slopes over the whole length (profiles: the
    /// evaluation length, helices: the face width), so that a part of it has its share of the
    /// limits, and a greater length no more than the whole limits. `along` converts the tolerances
    /// of the class, which are transverse, to the direction of the figures.
    pub(super) fn slope_over(
        &self,
        kind: Kind,
        share: f64,
        along: f64,
        tolerances: Option<&Tolerances>,
        rounding: Rounding,
    ) -> Option<[f64; 2]> {
        let of_class = || Some(self.slope_of_class(kind, tolerances?, rounding)?.map(|end| along * end));
        let whole = self.slope(kind).or_else(of_class)?;
        let share = share.min(1.0);
        Some(whole.map(|end| end * share))
    }

    /// Limits of a slope as given.
    fn slope(&self, kind: Kind) -> Option<[f64; 2]> {
        match kind {
            Kind::Profile => self.profile_slope_um,
            Kind::Helix => self.helix_slope_um,
        }
    }

    /// Limits of a slope by the class.
    fn slope_of_class(&self, kind: Kind, tolerances: &Tolerances, rounding: Rounding) -> Option<[f64; 2]> {
        let characteristic = match kind {
            Kind::Profile => Characteristic::ProfileSlope,
            Kind::Helix => Characteristic::HelixSlope,
        };
        self.of_class(characteristic, tolerances, rounding).map(|tolerance| [-tolerance, tolerance])
    }

    fn of_class(&self, characteristic: Characteristic, tolerances: &Tolerances, rounding: Rounding) -> Option<f64> {
        tolerances.tolerance(characteristic, self.class?, rounding)
    }

    /// Limits of a trace: as given, else those of the class.
    pub(super) fn of_trace(&self, kind: Kind, tolerances: Option<&Tolerances>, rounding: Rounding) -> TraceLimits {
        let [form, total] = match kind {
            Kind::Profile => [self.profile_form_um, self.profile_total_um],
            Kind::Helix => [self.helix_form_um, self.helix_total_um],
        };
        let [form_of, total_of] = match kind {
            Kind::Profile => [Characteristic::ProfileForm, Characteristic::ProfileTotal],
            Kind::Helix => [Characteristic::HelixForm, Characteristic::HelixTotal],
        };
        // neither is ever below 0
        let of_class = |of| self.of_class(of, tolerances?, rounding).map(|tolerance| [0.0, tolerance]);
        TraceLimits {
            slope: self.slope_over(kind, 1.0, 1.0, tolerances, rounding),
            form: form.or_else(|| of_class(form_of)),
            total: total.or_else(|| of_class(total_of)),
            crowning: self.crowning(kind),
        }
    }

    /// Limits of a crowning.
    pub(super) fn crowning(&self, kind: Kind) -> Option<[f64; 2]> {
        match kind {
            Kind::Profile => self.profile_crowning_um,
            Kind::Helix => self.helix_crowning_um,
        }
    }
}
