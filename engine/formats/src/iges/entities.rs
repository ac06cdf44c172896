//! Parameters and directory entries of the entities in use.

use super::super::{
    cad::{CadCurve, CadSurface, Piece},
    number::iges_real,
    text::hollerith,
};
use flankfit_geometry::space::Vector;

/// An entity with its fields, the first of which is its type.
pub(super) struct Entity {
    kind: u16,
    form: u16,
    /// Blank, subordinate, use and hierarchy, two digits each.
    status: &'static str,
    label: String,
    pub(super) parameters: Vec<String>,
}

impl Entity {
    /// A curve or surface; `property` is the directory card of its name.
    pub(super) fn of_piece(piece: &Piece, name: &str, property: Option<usize>) -> Self {
        let (kind, mut parameters) = match piece {
            Piece::Curve(curve) => (126, curve_parameters(curve)),
            Piece::Surface(surface) => (128, surface_parameters(surface)),
        };
        if let Some(card) = property {
            // no associativities, one property
            parameters.extend(["0".to_owned(), "1".to_owned(), card.to_string()]);
        }
        let label = name.chars().filter(char::is_ascii_alphanumeric).take(8).collect();
        Entity { kind, form: 0, status: "00000000", label, parameters }
    }

    /// Property 406, form 15: the name of the entity that points to it.
    pub(super) fn of_name(name: &str) -> Self {
        let parameters = vec!["406".to_owned(), "1".to_owned(), hollerith(name)];
        Entity { kind: 406, form: 15, status: "00020200", label: String::new(), parameters }
    }

    /// Both cards of the directory entry, given the first card of the parameters and how many they
    /// are.
    pub(super) fn directory(&self, first: usize, lines: usize) -> [String; 2] {
        let Entity { kind, form, status, label, .. } = self;
        [
            format!("{kind:>8}{first:>8}{0:>8}{0:>8}{0:>8}{0:>8}{0:>8}{0:>8}{status:>8}", 0),
            format!("{kind:>8}{0:>8}{0:>8}{lines:>8}{form:>8}{blank:>8}{blank:>8}{label:>8}{0:>8}", 0, blank = ""),
        ]
    }
}

/// 126: K, M, planar, closed, polynomial, periodic, knots, weights, points, domain, normal.
fn curve_parameters(curve: &CadCurve) -> Vec<String> {
    let normal = curve.normal();
    let mut fields = vec!["126".to_owned(), (curve.axis.size() - 1).to_string(), curve.axis.degree.to_string()];
    fields.extend([normal.is_some(), curve.is_closed(), curve.weights.is_none(), false].map(flag));
    fields.extend(reals(&curve.axis.knots));
    extend_with_controls(&mut fields, &curve.points, curve.weights.as_deref(), 0..curve.points.len());
    let (low, high) = curve.axis.domain();
    fields.extend(reals(&[low, high]));
    fields.extend(reals(normal.unwrap_or_else(Vector::zeros).as_slice()));
    fields
}

/// 128: K1, K2, M1, M2, closed in u and v, polynomial, periodic in u and v, knots, weights, points
/// (u fastest), domain.
fn surface_parameters(surface: &CadSurface) -> Vec<String> {
    let [along_u, along_v] = &surface.axes;
    let (m, n) = (along_u.size(), along_v.size());
    let [closed_u, closed_v] = surface.is_closed();
    let mut fields = vec!["128".to_owned()];
    fields.extend([m - 1, n - 1, along_u.degree, along_v.degree].map(|count| count.to_string()));
    fields.extend([closed_u, closed_v, surface.weights.is_none(), false, false].map(flag));
    fields.extend(reals(&along_u.knots));
    fields.extend(reals(&along_v.knots));
    let u_fastest = (0..n).flat_map(|j| (0..m).map(move |i| i * n + j));
    extend_with_controls(&mut fields, &surface.points, surface.weights.as_deref(), u_fastest);
    let ((u_low, u_high), (v_low, v_high)) = (along_u.domain(), along_v.domain());
    fields.extend(reals(&[u_low, u_high, v_low, v_high]));
    fields
}

/// Weights, then coordinates, of the controls in this order.
fn extend_with_controls(
    fields: &mut Vec<String>,
    points: &[Vector],
    weights: Option<&[f64]>,
    order: impl Iterator<Item = usize> + Clone,
) {
    fields.extend(order.clone().map(|i| iges_real(weights.map_or(1.0, |w| w[i]))));
    fields.extend(order.flat_map(|i| reals(points[i].as_slice())));
}

fn flag(set: bool) -> String {
    u8::from(set).to_string()
}

fn reals(numbers: &[f64]) -> impl Iterator<Item = String> {
    numbers.iter().map(|x| iges_real(*x))
}
