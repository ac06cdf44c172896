//! State as plain numbers, restored exactly.

use super::{
    state::{Numbers, State},
    sums::Sums,
};
use crate::{
    data::Form,
    design::{Basis, Boxes, MOST_COEFFICIENTS, of_columns, product_on},
    problem::SummaryStatistics,
    spec::FitSpec,
};
use flankfit_numerics::Triangle;

impl Sums {
    pub(super) fn state(&self) -> State {
        let mut numbers = Vec::new();
        let (form, names) = match &self.form {
            Form::Curve => (0.0, None),
            Form::Surface => (1.0, None),
            Form::Matrix { names, .. } => (2.0, names.clone()),
        };
        numbers.extend([form, self.design.size() as f64, self.summary.count as f64]);
        numbers.extend(self.boxes.0.into_iter().chain(self.boxes.1));
        numbers.extend(self.largest);
        numbers.extend(self.summary.bounds.as_flattened());
        numbers.extend(self.summary.rounded_places);
        numbers.push(f64::from(u8::from(self.summary.rounded_heights)));
        let triangle = self.triangle.rows().iter().chain(self.triangle.qty());
        for x in triangle.chain([&self.summary.rss]).chain(&self.moments).chain(&self.ones) {
            numbers.extend([x.hi, x.lo]);
        }
        numbers.extend(&self.summary.slopes);
        if let Basis::Columns { scale } = &self.design.basis {
            numbers.extend(scale.iter().chain(&self.first).chain(&self.summary.rounded_columns));
            numbers.extend(self.same.iter().map(|&same| f64::from(u8::from(same))));
        }
        State { numbers, names }
    }

    pub(super) fn restore(spec: &FitSpec, state: &State) -> Option<Self> {
        let mut input = Numbers::new(&state.numbers);
        let [form, size, count] = input.array()?;
        let (n, count) = (size as usize, count as usize);
        if n > MOST_COEFFICIENTS {
            return None;
        }
        let boxes: Boxes = (input.array()?, input.array()?);
        let largest = input.array()?;
        let bounds = [input.array()?, input.array()?];
        let rounded_places = input.array()?;
        let [rounded_heights] = input.array()?;
        let triangle = (input.wide(n * (n + 1) / 2)?, input.wide(n)?);
        let rss = input.wide(1)?[0];
        let triangle = Triangle::from_parts(n, triangle.0, triangle.1, rss)?;
        let moments = input.wide(3)?.try_into().ok()?;
        let ones = input.wide(n)?;
        let slopes = input.take(if spec.node_uncertainty.is_some() { n } else { 0 })?;
        let matrix = form == 2.0;
        let columns = if matrix { n } else { 0 };
        let (scale, first, rounded_columns) = (input.take(columns)?, input.take(columns)?, input.take(columns)?);
        let same: Vec<bool> = input.take(columns)?.iter().map(|&x| x != 0.0).collect();
        let (form, design) = if matrix {
            let form = Form::Matrix { columns: n, names: state.names.clone() };
            (form, of_columns(scale, &[], state.names.as_deref()))
        } else {
            let surface = form == 1.0;
            let form = if surface { Form::Surface } else { Form::Curve };
            (form, product_on(surface, &spec.model, boxes, boxes).ok()?)
        };
        let summary = SummaryStatistics {
            count,
            rss,
            rounded_heights: rounded_heights != 0.0,
            rounded_places,
            bounds,
            rounded_columns,
            slopes,
        };
        (design.size() == n && input.is_at_end()).then_some(Sums {
            form,
            design,
            boxes,
            triangle,
            ones,
            moments,
            largest,
            first,
            same,
            summary,
        })
    }
}
