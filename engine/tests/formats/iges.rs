//! IGES: cards, counts and pointers; knots, weights and points come back bit by bit.

use flankfit_engine::{
    formats::{CadShape, NamedShape, iges},
    geometry::{curve::BSplineCurve, surface::BSplineSurface},
};
use proptest::prelude::*;

use super::{
    iges_file::{Entity, Field, File, read},
    shapes::{curves, label, names, surfaces},
};

fn bits<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> Vec<u64> {
    numbers.into_iter().map(|x| x.to_bits()).collect()
}

/// The reals of an entity, read one group after the other.
struct Reals<'a>(&'a [Field]);

impl Reals<'_> {
    fn take(&mut self, count: usize) -> Vec<f64> {
        let (taken, rest) = self.0.split_at(count);
        self.0 = rest;
        taken.iter().map(Field::real).collect()
    }
}

fn weights_of(weights: Option<&[f64]>, count: usize) -> Vec<f64> {
    weights.map_or(vec![1.0; count], <[f64]>::to_vec)
}

/// Equal weights are none.
fn is_polynomial(weights: Option<&[f64]>) -> bool {
    weights.is_none_or(|w| w.iter().all(|x| *x == w[0]))
}

/// Name and directory card follow the parameters proper.
fn check_name(file: &File, rest: &[Field], name: &str) {
    if name.is_empty() {
        assert!(rest.is_empty());
        return;
    }
    let [none, one, card] = rest else { panic!("{rest:?}") };
    assert_eq!((none.integer(), one.integer()), (0, 1));
    let property = &file.entities[&card.integer()];
    assert_eq!((property.kind, property.form), (406, 15));
    let shown = |c: char| match c {
        '\n' => ' ',
        c if c.is_ascii() => c,
        _ => '?',
    };
    let expected: String = name.chars().map(shown).collect();
    assert_eq!(property.parameters[1..], [Field::Integer(1), Field::Text(expected)]);
}

fn check_curve(file: &File, entity: &Entity, curve: &BSplineCurve, name: &str) {
    let (basis, fields) = (curve.basis(), &entity.parameters);
    assert_eq!((entity.kind, entity.form), (126, 0));
    let counts: Vec<usize> = fields[1..7].iter().map(Field::integer).collect();
    let (last, degree) = (counts[0], counts[1]);
    assert_eq!((last + 1, degree), (basis.size(), basis.degree()));
    let closed = curve.control_points().first() == curve.control_points().last();
    assert_eq!(counts[3..], [usize::from(closed), usize::from(is_polynomial(curve.weights())), 0]);
    let mut reals = Reals(&fields[7..]);
    assert_eq!(bits(&reals.take(last + degree + 2)), bits(basis.knots()));
    let weights = if counts[4] == 1 { vec![1.0; last + 1] } else { weights_of(curve.weights(), last + 1) };
    assert_eq!(bits(&reals.take(last + 1)), bits(&weights));
    let points: Vec<f64> = curve.control_points().iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    assert_eq!(bits(&reals.take(3 * (last + 1))), bits(&points));
    assert_eq!(reals.take(2), [basis.domain().0, basis.domain().1]);
    let normal = reals.take(3);
    assert_eq!(normal.iter().map(|x| x * x).sum::<f64>(), counts[2] as f64);
    check_name(file, reals.0, name);
}

fn check_surface(file: &File, entity: &Entity, surface: &BSplineSurface, name: &str) {
    let ([u, v], fields) = (surface.bases(), &entity.parameters);
    assert_eq!((entity.kind, entity.form), (128, 0));
    let counts: Vec<usize> = fields[1..10].iter().map(Field::integer).collect();
    let (m, n) = (u.size(), v.size());
    assert_eq!(counts[..4], [m - 1, n - 1, u.degree(), v.degree()]);
    let polynomial = is_polynomial(surface.weights());
    assert_eq!(counts[6..], [usize::from(polynomial), 0, 0]);
    let mut reals = Reals(&fields[10..]);
    assert_eq!(bits(&reals.take(u.knots().len())), bits(u.knots()));
    assert_eq!(bits(&reals.take(v.knots().len())), bits(v.knots()));
    let weights = if polynomial { vec![1.0; m * n] } else { weights_of(surface.weights(), m * n) };
    // the standard lets the index along u run fastest
    let order: Vec<usize> = (0..n).flat_map(|j| (0..m).map(move |i| i * n + j)).collect();
    assert_eq!(bits(&reals.take(m * n)), bits(order.iter().map(|i| &weights[*i])));
    let points: Vec<f64> =
        order.iter().flat_map(|i| surface.control_points()[*i].iter().copied().collect::<Vec<_>>()).collect();
    assert_eq!(bits(&reals.take(3 * m * n)), bits(&points));
    assert_eq!(reals.take(4), [u.domain().0, u.domain().1, v.domain().0, v.domain().1]);
    check_name(file, reals.0, name);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn shapes_come_back(curve in curves(), surface in surfaces(), first in names(), second in names()) {
        let shapes = [
            NamedShape { name: &first, shape: CadShape::Curve(&curve) },
            NamedShape { name: &second, shape: CadShape::Surface(&surface) },
        ];
        let file = read(&iges::write(&shapes, &label()).expect("a file"));
        let drawn: Vec<&Entity> = file.order.iter().map(|at| &file.entities[at]).filter(|e| e.kind != 406).collect();
        let [a, b] = drawn[..] else { panic!("{} shapes", drawn.len()) };
        check_curve(&file, a, &curve, &first);
        check_surface(&file, b, &surface, &second);
        prop_assert!(a.label.len() <= 8);
        prop_assert!(first.contains(a.label.chars().next().unwrap_or('\0')) != a.label.is_empty());
    }
}

#[test]
fn the_global_section_has_millimetres() {
    let surface = super::shapes::bilinear([[0., 0., 0.], [0., 1., -70.5], [1., 0., 0.], [1., 1., 0.]]);
    let shapes = [NamedShape { name: "", shape: CadShape::Surface(&surface) }];
    let text = iges::write(&shapes, &label()).expect("a file");
    let file = read(&text);
    let text_field = |text: &str| Field::Text(text.to_owned());
    assert_eq!(file.global.len(), 26);
    assert_eq!(file.global[2], text_field("Rad 'z = 52'; ?, \\ 20?"));
    assert_eq!(file.global[12..15], [Field::Real(1.0), Field::Integer(2), text_field("MM")]);
    assert_eq!(file.global[17], text_field("20261121.160509"));
    assert_eq!(file.global[19], Field::Real(70.5));
    assert_eq!(file.global[20..23], [text_field("A. N. Other"), text_field("Zahnr?der, S?hne"), Field::Integer(11)]);
    assert_eq!(iges::write(&shapes, &label()).as_ref(), Ok(&text));
}
