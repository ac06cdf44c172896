//! Wire types of the description of nodes: flank, tooth and axes.
//!
//! Quantities and units may be words of the caller's own. Only those known here are ever reckoned
//! with; where a known one is needed and another is given, the request is refused.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::units;
use crate::{
    api::{
        faults::Faults,
        json::{request::request, text::ShortText, writer::text_of},
    },
    jobs::Measurand,
};
use flankfit_engine::{
    estimation::{FitSpec, Nodes, Recursive},
    gear::{ProfileAxis, Side, evaluation::OwnZeros, tooth::check_name},
};

request! {
    /// Measurand of the nodes. A fit does not depend on it; everything derived from a stored
    /// iteration does.
    #[derive(Default, Deserialize)]
    #[serde(deny_unknown_fields)]
    pub struct MeasurandBody as MeasurandMembers, read whole {
        /// The flank that was measured.
        optional flank: Side,
        /// The tooth that was measured, as on traces: its number from 1, or a name.
        #[schema(value_type = Option<String>, min_length = 1, max_length = 200, example = "1")]
        optional tooth: ShortText,
        /// Quantities and units on the axes of the nodes.
        optional axes: AxesBody,
    }
}

/// Quantities and units on the axes of nodes: `u`, `v` and `z` of a surface, `x` and `y` of a
/// curve, `y` of a measurement matrix.
#[skip_serializing_none]
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = Axes, example = json!({
    "u": {"quantity": "roll_length", "unit": "mm"},
    "v": {"quantity": "face_width", "unit": "mm"},
    "z": {"quantity": "deviation", "unit": "um", "positive": "material_out"}
}))]
pub struct AxesBody {
    /// First abscissa of a surface.
    pub u: Option<AxisBody>,
    /// Second abscissa of a surface.
    pub v: Option<AxisBody>,
    /// Heights of a surface.
    pub z: Option<AxisBody>,
    /// Abscissa of a curve.
    pub x: Option<AxisBody>,
    /// Heights of a curve or of a measurement matrix.
    pub y: Option<AxisBody>,
}

/// Quantity and unit of the numbers on an axis.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = Axis)]
pub struct AxisBody {
    /// `roll_length` (with the unit `deg` or `arcmin`: the roll angle), `diameter`, `face_width`,
    /// `deviation`, or another word.
    #[schema(value_type = String, min_length = 1, max_length = 200, example = "deviation")]
    pub quantity: ShortText,
    /// `nm`, `um`, `mm`, `in`, `deg`, `arcmin`, or another word. `µm` and other usual spellings are
    /// accepted and returned as these names.
    #[schema(value_type = String, min_length = 1, max_length = 200, example = "um")]
    pub unit: ShortText,
    /// For heights: meaning of a positive value. Default `material_out`.
    pub positive: Option<PositiveName>,
    /// For heights measured as traces with separate zeros: number of nodes of each trace, in the
    /// order of the nodes. A correction then ignores the mean of each trace. Absent if all heights
    /// have one zero.
    #[schema(example = json!([480, 480, 240]))]
    pub trace_lengths: Option<Vec<u32>>,
}

/// Meaning of a positive height.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = PositiveHeight)]
pub enum PositiveName {
    /// Protruding material.
    MaterialOut,
    /// Material is missing.
    MaterialIn,
}

/// A type of nodes and the axes it has.
type Kind = (&'static str, &'static [&'static str]);

const CURVE: Kind = ("curve", &["x", "y"]);
const MATRIX: Kind = ("matrix", &["y"]);
const SCATTERED: Kind = ("scattered", &["u", "v", "z"]);
const GRID: Kind = ("grid", &["u", "v", "z"]);

/// End of the message about a unit that is not a length.
const KNOWN_LENGTHS: &str = "`nm`, `um`, `mm` and `in` are known";
/// Quantities that are lengths and never angles.
const LENGTHS: [&str; 2] = ["diameter", "face_width"];

impl MeasurandBody {
    /// The domain's form, after a look at the kind of nodes where it is known.
    pub fn checked(&self, nodes: Option<&Nodes>) -> Result<Measurand, Faults> {
        self.checked_for(&nodes.map_or(vec![SCATTERED, CURVE, MATRIX], |nodes| vec![kind_of(nodes)]), nodes)
    }

    /// The same for nodes that are still to come, of the kinds that the spec of their stream takes.
    pub fn checked_for_stream(&self, spec: &FitSpec) -> Result<Measurand, Faults> {
        let taken = Recursive::takes(spec);
        let kinds = [(taken.surfaces, SCATTERED), (taken.curves, CURVE), (taken.matrices, MATRIX)];
        let kinds: Vec<Kind> = kinds.into_iter().filter_map(|(taken, kind)| taken.then_some(kind)).collect();
        self.checked_for(&kinds, None)
    }

    fn checked_for(&self, kinds: &[Kind], nodes: Option<&Nodes>) -> Result<Measurand, Faults> {
        let mut faults = Faults::default();
        if let Some(axes) = &self.axes {
            axes.check(kinds, nodes, &mut faults);
        }
        if let Some(fault) = self.tooth.as_ref().and_then(|tooth| check_name(tooth.as_str()).err()) {
            faults.push("/tooth", fault.to_string());
        }
        let axes = self.axes.clone().map(|axes| Arc::from(text_of(&axes.canonical())));
        let tooth = self.tooth.clone().map(String::from);
        faults.into_result(Measurand { flank: self.flank, tooth, axes, accept_units: false })
    }
}

impl AxesBody {
    /// Reads the axes stored with a measurand.
    pub fn of(measurand: &Measurand) -> Result<Self, String> {
        let Some(text) = &measurand.axes else { return Ok(AxesBody::default()) };
        serde_json::from_str(text).map_err(|error| format!("the stored axes cannot be read: {error}"))
    }

    /// Returns these axes with canonical names of units.
    fn canonical(mut self) -> Self {
        let axes = [&mut self.u, &mut self.v, &mut self.z, &mut self.x, &mut self.y];
        for axis in axes.into_iter().flatten() {
            axis.unit = ShortText::new(units::canonical(axis.unit.as_str())).unwrap_or_else(|| axis.unit.clone());
        }
        self
    }

    /// Returns these axes, and those of `before` for the axes that are missing here.
    pub fn over(self, before: AxesBody) -> Self {
        AxesBody {
            u: self.u.or(before.u),
            v: self.v.or(before.v),
            z: self.z.or(before.z),
            x: self.x.or(before.x),
            y: self.y.or(before.y),
        }
    }

    /// By their names.
    pub fn named(&self) -> [(&'static str, Option<&AxisBody>); 5] {
        let AxesBody { u, v, z, x, y } = self;
        [("u", u.as_ref()), ("v", v.as_ref()), ("z", z.as_ref()), ("x", x.as_ref()), ("y", y.as_ref())]
    }

    /// Refuses axes that no nodes of these kinds have, or none have together, and what is not so of
    /// the nodes where they are known.
    fn check(&self, kinds: &[Kind], nodes: Option<&Nodes>, faults: &mut Faults) {
        let strange = |(_, known): &&Kind| {
            self.named().iter().filter(|(name, axis)| axis.is_some() && !known.contains(name)).count()
        };
        let Some((kind, known)) = kinds.iter().min_by_key(strange) else { return };
        for (name, axis) in self.named() {
            let Some(axis) = axis else { continue };
            let at = format!("/axes/{name}");
            if !known.contains(&name) {
                faults.push(&at, format!("nodes of type `{kind}` have no `{name}`; they have {}", known.join(", ")));
            }
            if axis.positive.is_some() && !["z", "y"].contains(&name) {
                faults.push(format!("{at}/positive"), "it belongs to heights, `z` or `y`");
            }
            if let Some(lengths) = &axis.trace_lengths {
                check_lengths(lengths, name, nodes, faults);
            }
            let (quantity, unit) = (axis.quantity.as_str(), axis.unit.as_str());
            if LENGTHS.contains(&quantity) && ["deg", "arcmin"].contains(&units::canonical(unit)) {
                faults.push(format!("{at}/unit"), format!("`{quantity}` is a length; write `mm`, `um`, `nm` or `in`"));
            }
        }
    }

    /// The trace that each node belongs to, by numbers from 0; `None` where all heights count from
    /// one zero.
    pub fn traces(&self) -> Option<Vec<usize>> {
        let lengths = self.z.as_ref().or(self.y.as_ref())?.trace_lengths.as_ref()?;
        let each = lengths.iter().enumerate();
        Some(each.flat_map(|(trace, length)| std::iter::repeat_n(trace, *length as usize)).collect())
    }

    /// Returns the factor that converts a height to a deviation in µm, positive where material
    /// protrudes: 1 if nothing is given.
    pub fn deviation_factor(&self) -> Result<f64, String> {
        let Some(axis) = self.z.as_ref().or(self.y.as_ref()) else { return Ok(1.0) };
        let quantity = axis.quantity.as_str();
        if quantity == "roll_length" || LENGTHS.contains(&quantity) {
            return Err(format!("the heights of the iteration are `{quantity}`, not deviations"));
        }
        let Some(unit) = units::micrometres(axis.unit.as_str()) else {
            return Err(format!("the heights of the iteration are in `{}`; {KNOWN_LENGTHS}", axis.unit.as_str()));
        };
        Ok(if axis.positive == Some(PositiveName::MaterialIn) { -unit } else { unit })
    }

    /// Returns the quantity of u, with the factor that converts it to the unit of the coordinate;
    /// `None` if nothing is given.
    pub fn profile(&self) -> Result<Option<(ProfileAxis, f64)>, String> {
        let Some(axis) = &self.u else { return Ok(None) };
        match (axis.quantity.as_str(), axis.unit.as_str()) {
            ("roll_length", "deg") => Ok(Some((ProfileAxis::RollAngle, 1.0))),
            ("roll_length", "arcmin") => Ok(Some((ProfileAxis::RollAngle, 1.0 / 60.0))),
            ("roll_length", unit) => Ok(Some((ProfileAxis::RollLength, to_mm("u", unit)?))),
            ("diameter", unit) => Ok(Some((ProfileAxis::Diameter, to_mm("u", unit)?))),
            (other, _) => Err(format!(
                "u of the iteration is `{other}`; along the profile `roll_length` and `diameter` are known"
            )),
        }
    }

    /// Returns the factor that converts v to z of the gear in mm.
    pub fn along(&self) -> Result<f64, String> {
        let Some(axis) = &self.v else { return Ok(1.0) };
        match (axis.quantity.as_str(), axis.unit.as_str()) {
            ("face_width", unit) => to_mm("v", unit),
            (other, _) => Err(format!("v of the iteration is `{other}`; along the axis `face_width` is known")),
        }
    }
}

/// Lengths of traces belong to heights and add up to the nodes.
fn check_lengths(lengths: &[u32], name: &str, nodes: Option<&Nodes>, faults: &mut Faults) {
    let at = format!("/axes/{name}/trace_lengths");
    if !["z", "y"].contains(&name) {
        faults.push(at, "it belongs to heights, `z` or `y`");
        return;
    }
    let Some(nodes) = nodes else {
        faults.push(
            at,
            "nodes that arrive block by block have no traces yet; omit it, and give them as `trace` of a correction",
        );
        return;
    };
    let count = nodes.posted();
    let whole: u64 = lengths.iter().map(|length| u64::from(*length)).sum();
    if let Some(k) = lengths.iter().position(|length| *length == 0) {
        faults.push(format!("{at}/{k}"), "a trace has at least one node; omit empty ones");
    } else if whole != count as u64 {
        faults.push(at, format!("the traces have {whole} nodes in all, but there are {count}"));
    }
}

fn kind_of(nodes: &Nodes) -> Kind {
    match nodes {
        Nodes::Curve(_) => CURVE,
        Nodes::Matrix(_) => MATRIX,
        Nodes::Scattered(_) => SCATTERED,
        Nodes::Grid(_) => GRID,
    }
}

fn to_mm(axis: &str, unit: &str) -> Result<f64, String> {
    units::millimetres(unit).ok_or_else(|| format!("{axis} of the iteration is in `{unit}`; {KNOWN_LENGTHS}"))
}

/// Refuses nodes of a stream that its axes are not those of.
pub fn check_block(of: &Measurand, nodes: &Nodes) -> Result<(), Faults> {
    let mut faults = Faults::default();
    if of.axes.is_some() {
        AxesBody::of(of).map_err(|why| Faults::one("/nodes", why))?.check(&[kind_of(nodes)], Some(nodes), &mut faults);
    }
    match faults.list().first() {
        Some(fault) => Err(Faults::one("/nodes/type", format!("the stream has axes of other nodes: {}", fault.detail))),
        None => Ok(()),
    }
}

/// The lengths of traces with separate zeros, as an axis has them.
pub fn trace_lengths(zeros: &OwnZeros) -> Vec<u32> {
    zeros.lengths.iter().map(|length| u32::try_from(*length).unwrap_or(u32::MAX)).collect()
}

/// An axis whose quantity and unit are known here.
pub fn known_axis(quantity: &str, unit: &str, positive: Option<PositiveName>) -> Option<AxisBody> {
    Some(AxisBody { quantity: ShortText::new(quantity)?, unit: ShortText::new(unit)?, positive, trace_lengths: None })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axes(text: &str) -> AxesBody {
        serde_json::from_str(text).unwrap()
    }

    #[test]
    fn heights_become_micrometres_of_material() {
        for (text, factor) in [
            ("{}", Some(1.0)),
            (r#"{"z":{"quantity":"deviation","unit":"um"}}"#, Some(1.0)),
            (r#"{"z":{"quantity":"deviation","unit":"mm","positive":"material_out"}}"#, Some(1000.0)),
            (r#"{"z":{"quantity":"deviation","unit":"mm","positive":"material_in"}}"#, Some(-1000.0)),
            (r#"{"y":{"quantity":"my own","unit":"um","positive":"material_in"}}"#, Some(-1.0)),
            (r#"{"z":{"quantity":"deviation","unit":"in"}}"#, Some(25_400.0)),
            (r#"{"z":{"quantity":"deviation","unit":"nm"}}"#, Some(1e-3)),
            (r#"{"z":{"quantity":"deviation","unit":"furlong"}}"#, None),
            (r#"{"z":{"quantity":"diameter","unit":"mm"}}"#, None),
        ] {
            assert_eq!(axes(text).deviation_factor().ok(), factor, "{text}");
        }
    }

    #[test]
    fn axes_are_checked_against_the_nodes() {
        let curve = Nodes::curve(vec![0.0, 1.0], vec![2.0, 3.0], None).unwrap();
        let pointers = |text: &str, nodes: Option<&Nodes>| -> Vec<String> {
            let body = MeasurandBody { axes: Some(axes(text)), ..MeasurandBody::default() };
            let faults = body.checked(nodes).err().unwrap_or_default();
            faults.list().iter().map(|fault| fault.pointer.clone()).collect()
        };
        let along = r#"{"u":{"quantity":"roll_length","unit":"mm"}}"#;
        assert_eq!(pointers(along, Some(&curve)), ["/axes/u"]);
        assert!(pointers(along, None).is_empty());
        let both = r#"{"u":{"quantity":"roll_length","unit":"mm"},"x":{"quantity":"roll_length","unit":"mm"}}"#;
        assert_eq!(pointers(both, None), ["/axes/x"], "no nodes have both");
        let odd = r#"{"u":{"quantity":"diameter","unit":"deg","positive":"material_in"},"z":{"quantity":"deviation","unit":"µm"}}"#;
        assert_eq!(pointers(odd, None), ["/axes/u/positive", "/axes/u/unit"]);
    }

    #[test]
    fn units_are_stored_by_the_names_that_are_written() {
        let body = MeasurandBody {
            axes: Some(axes(
                r#"{"u":{"quantity":"roll_length","unit":"inch"},"z":{"quantity":"deviation","unit":"µm"}}"#,
            )),
            ..MeasurandBody::default()
        };
        let stored = AxesBody::of(&body.checked(None).unwrap()).unwrap();
        assert_eq!([stored.u, stored.z].map(|axis| axis.unwrap().unit.as_str().to_owned()), ["in", "um"]);
    }

    #[test]
    fn quantities_and_units_of_axes_are_known_or_refused() {
        let of = |quantity: &str, unit: &str| {
            axes(&format!(
                r#"{{"u":{{"quantity":"{quantity}","unit":"{unit}"}},"v":{{"quantity":"{quantity}","unit":"{unit}"}}}}"#
            ))
        };
        assert_eq!(of("roll_length", "deg").profile(), Ok(Some((ProfileAxis::RollAngle, 1.0))));
        assert_eq!(of("diameter", "um").profile(), Ok(Some((ProfileAxis::Diameter, 1e-3))));
        assert_eq!(AxesBody::default().profile(), Ok(None));
        assert!(of("face_width", "mm").profile().is_err() && of("roll_length", "furlong").profile().is_err());
        assert_eq!(of("face_width", "um").along(), Ok(1e-3));
        assert!(of("roll_length", "mm").along().is_err());
    }
}
