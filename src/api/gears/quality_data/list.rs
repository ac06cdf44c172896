//! Characteristics in the making: each gets a number that no other one has.

use std::collections::HashSet;

use flankfit_engine::{
    formats::qdas::{Characteristic, one_line},
    gear::Side,
};

/// Characters of a number.
const LONGEST: usize = 20;

/// Characteristics, µm.
#[derive(Default)]
pub struct List {
    numbers: HashSet<String>,
    all: Vec<Characteristic>,
}

impl List {
    /// Adds one. A second one of the same number gets the suffix `~2`.
    pub fn push(&mut self, number: &str, name: String, value: Option<f64>, limits: [Option<f64>; 2]) {
        let mut own = one_line(number, LONGEST);
        let mut count = 1;
        while !self.numbers.insert(own.clone()) {
            count += 1;
            let suffix = format!("~{count}");
            own = format!("{}{suffix}", one_line(number, LONGEST.saturating_sub(suffix.len())));
        }
        let [lower_limit, upper_limit] = limits;
        self.all.push(Characteristic { number: own, name, unit: "µm", lower_limit, upper_limit, value });
    }

    pub fn into_vec(self) -> Vec<Characteristic> {
        self.all
    }
}

/// As numbers and names say it.
pub fn flank(side: Side) -> (&'static str, &'static str) {
    match side {
        Side::Left => ("L", "left flank"),
        Side::Right => ("R", "right flank"),
    }
}
