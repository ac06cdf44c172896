//! Whether a later iteration measured the nodes of a correction, whatever its axes call them.
//!
//! Where both iterations tell the same axes their numbers must be equal. Where they do not, nodes
//! on a gear's flank are compared by their places on it, others by the units of one quantity; what
//! cannot be turned into each other is not the same, and it is said why.

use super::chosen::ChosenFigures;
use crate::{
    api::measurand::{
        axes::{AxesBody, AxisBody},
        units,
    },
    jobs::Measurand,
};
use flankfit_engine::{estimation::Nodes, gear::correction::Flank};

/// Nodes with what they are of.
pub struct Measured {
    /// Number of the iteration.
    pub number: u32,
    pub nodes: Nodes,
    pub measurand: Measurand,
    /// Figures of its chosen fit.
    pub chosen: ChosenFigures,
}

impl Measured {
    /// Returns why its units are implausible; `None` where they are not, or have been accepted.
    pub fn implausible(&self) -> Option<&str> {
        self.chosen.figures.implausible().filter(|_| !self.measurand.accept_units)
    }
}

/// Places that were turned from one coordinate into another are the same within this, mm: units and
/// angles are posted with so many digits, and a flank that leans by 10 µm per mm is 0.01 µm higher
/// there.
const SAME_PLACE: f64 = 1e-3;

/// Why the nodes are not the same, or why it is not known. The flanks are those that the nodes lie
/// on, with a machine.
pub fn same_nodes(before: &Measured, after: &Measured, flanks: Option<[&Flank; 2]>, number: u32) -> Result<(), String> {
    let elsewhere = || {
        let [later, earlier] = [after, before].map(|of| words(&of.nodes));
        Err(format!("iteration {number} has {later} at other places than the {earlier} before: measure the same nodes"))
    };
    let pairs: Vec<(&str, &[f64], &[f64])> = match (&before.nodes, &after.nodes) {
        (Nodes::Curve(a), Nodes::Curve(b)) => vec![("x", a.x(), b.x())],
        (Nodes::Scattered(a), Nodes::Scattered(b)) => vec![("u", a.u(), b.u()), ("v", a.v(), b.v())],
        (Nodes::Grid(a), Nodes::Grid(b)) => vec![("u", a.u(), b.u()), ("v", a.v(), b.v())],
        (Nodes::Matrix(a), Nodes::Matrix(b)) if a.x() == b.x() => Vec::new(),
        _ => return elsewhere(),
    };
    if pairs.iter().any(|(_, a, b)| a.len() != b.len()) {
        return elsewhere();
    }
    let axes = [AxesBody::of(&before.measurand)?, AxesBody::of(&after.measurand)?];
    let axes_named = |name: &str| axes.each_ref().map(|axes| axes.named().into_iter().find(|(n, _)| *n == name)?.1);
    let heights = if matches!(before.nodes, Nodes::Curve(_) | Nodes::Matrix(_)) { "y" } else { "z" };
    let quantities = axes_named(heights).map(|axis| axis.map_or("deviation", |axis| axis.quantity.as_str()));
    if quantities[0] != quantities[1] {
        let [a, b] = quantities;
        return Err(format!("the heights of iteration {number} are `{b}`, those of the corrected one `{a}`"));
    }
    let alike = pairs.iter().all(|(name, _, _)| {
        let [a, b] = axes_named(name);
        a == b
    });
    if alike {
        return if pairs.iter().all(|(_, a, b)| a == b) { Ok(()) } else { elsewhere() };
    }
    if let Some([a, b]) = flanks {
        let mut places = a.places.iter().zip(&b.places);
        let near = |a: f64, b: f64| (a - b).abs() <= SAME_PLACE;
        let same = a.places.len() == b.places.len()
            && places.all(|(a, b)| near(a.roll_length, b.roll_length) && near(a.z, b.z));
        return if same { Ok(()) } else { elsewhere() };
    }
    for (name, a, b) in pairs {
        let [from, to] = axes_named(name).map(|axis| Meaning::of(name, axis));
        let Some([a_unit, b_unit]) = Meaning::comparable(from, to) else {
            return Err(format!(
                "{name} of iteration {number} is {}, that of the corrected one {}",
                to.words(),
                from.words()
            ));
        };
        let same = match a_unit == b_unit {
            true => a == b,
            false => a.iter().zip(b).all(|(a, b)| (a_unit * a - b_unit * b).abs() <= SAME_PLACE),
        };
        if !same {
            return elsewhere();
        }
    }
    Ok(())
}

/// Number and arrangement of nodes.
fn words(nodes: &Nodes) -> String {
    match nodes {
        Nodes::Grid(grid) => format!("{} × {} nodes", grid.u().len(), grid.v().len()),
        other => format!("{} nodes", other.posted()),
    }
}

/// Quantity and unit of an axis; `None` if they are not given and nothing is assumed.
#[derive(Clone, Copy, PartialEq)]
struct Meaning<'a>(Option<[&'a str; 2]>);

impl<'a> Meaning<'a> {
    /// Quantity and unit. Surfaces have roll lengths and z in mm where nothing is given.
    fn of(name: &str, axis: Option<&'a AxisBody>) -> Self {
        let axes_named = axis.map(|axis| [axis.quantity.as_str(), axis.unit.as_str()]);
        Meaning(axes_named.or(match name {
            "u" => Some(["roll_length", "mm"]),
            "v" => Some(["face_width", "mm"]),
            _ => None,
        }))
    }

    /// Returns the factors that convert both to one unit.
    fn comparable(a: Self, b: Self) -> Option<[f64; 2]> {
        if a == b {
            return Some([1.0; 2]);
        }
        let ([a, a_unit], [b, b_unit]) = (a.0?, b.0?);
        (a == b).then_some([units::millimetres(a_unit)?, units::millimetres(b_unit)?])
    }

    fn words(self) -> String {
        match self.0 {
            Some([quantity, unit]) => format!("`{quantity}` in `{unit}`"),
            None => "not given".to_owned(),
        }
    }
}
