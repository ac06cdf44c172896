//! Checked input of a study.

use super::outcome::Outcome;
use flankfit_numerics::{
    Rows,
    check::Faults,
    words::{Shown, counted, entries, listed},
};

/// Products `levels · repetitions · rows · columns²` that a study may take.
pub(super) const MOST_WORK: usize = 300_000_000;
/// Most repetitions and most levels.
pub(super) const MOST_REPETITIONS: usize = 10_000;
pub(super) const MOST_LEVELS: usize = 200;
/// Most repetitions of a study that is computed in parts.
const MOST_IN_PARTS: usize = 10_000_000;

/// Columns in which norms, eigenvalues and λ* are understood.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColumnScaling {
    /// As they are: the paper's.
    #[default]
    None,
    /// Divided by their lengths, coefficients multiplied by them.
    UnitLength,
}

/// Setup of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// Rows of X.
    pub x: Rows,
    /// A.
    pub coefficients: Vec<f64>,
    /// σ of a height.
    pub noise_sigma: f64,
    /// k, in the order of the answer.
    pub levels: Vec<f64>,
    /// Repetitions at each level, from 1.
    pub repetitions: usize,
    /// Seed of the draws: the same seed gives the same study.
    pub seed: u64,
    /// Columns in which norms, eigenvalues and λ* are understood.
    pub scaling: ColumnScaling,
}

/// A checked setup, in the columns in which it is computed.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// Row by row.
    pub(super) x: Vec<f64>,
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) coefficients: Vec<f64>,
    /// σ_signal of each column.
    pub(super) deviation: Vec<f64>,
    pub(super) noise_sigma: f64,
    pub(super) levels: Vec<f64>,
    pub(super) repetitions: usize,
    pub(super) seed: u64,
}

impl Study {
    /// Checks everything.
    pub fn new(setup: Setup) -> Result<Self, Faults> {
        Study::within(setup, MOST_REPETITIONS, MOST_WORK)
    }

    /// The same for a study whose repetitions are computed in parts: of the whole there may be far
    /// more, and what work a part may be is for whoever computes it to say.
    pub fn in_parts(setup: Setup) -> Result<Self, Faults> {
        Study::within(setup, MOST_IN_PARTS, usize::MAX)
    }

    /// True if a repetition is of the shape of those of this study.
    pub fn takes(&self, outcome: &Outcome) -> bool {
        outcome.levels.len() == self.levels.len() && outcome.along.len() == self.columns
    }

    fn within(setup: Setup, most_repetitions: usize, most_work: usize) -> Result<Self, Faults> {
        let mut faults = Faults::default();
        let (rows, columns) = (setup.x.count(), setup.x.iter().next().map_or(0, <[f64]>::len));
        if rows == 0 || columns == 0 {
            faults.push("x", "the matrix is empty");
        }
        for (i, row) in setup.x.iter().enumerate().filter(|(_, row)| row.len() != columns) {
            faults
                .push(format_args!("x[{i}]"), format_args!("{}, but the first row has {columns}", entries(row.len())));
        }
        if rows > 0 && columns > 0 && setup.x.values().iter().all(|x| *x == 0.0) {
            faults.push("x", "every entry is 0: nothing can be randomised");
        }
        if rows < columns {
            faults.push(
                "x",
                format_args!("{columns} coefficients cannot be determined from {}", counted(rows, "row", "rows")),
            );
        }
        if setup.coefficients.len() != columns {
            faults.push(
                "coefficients",
                format_args!(
                    "{}, but the matrix has {}",
                    entries(setup.coefficients.len()),
                    counted(columns, "column", "columns")
                ),
            );
        }
        if !(setup.noise_sigma >= 0.0 && setup.noise_sigma.is_finite()) {
            faults.push(
                "noise_sigma",
                format_args!("{} is not a standard deviation: it must be 0 or more", Shown(setup.noise_sigma)),
            );
        }
        if setup.levels.is_empty() || setup.levels.len() > MOST_LEVELS {
            faults.push("levels", format_args!("{} levels; 1 to {MOST_LEVELS} are possible", setup.levels.len()));
        }
        for (i, level) in setup.levels.iter().enumerate().filter(|(_, k)| !(**k >= 0.0 && k.is_finite())) {
            faults.push(
                format_args!("levels[{i}]"),
                format_args!("{} is not a ratio of standard deviations: it must be 0 or more", Shown(*level)),
            );
        }
        if setup.repetitions == 0 || setup.repetitions > most_repetitions {
            faults.push(
                "repetitions",
                format_args!("{} repetitions; 1 to {most_repetitions} are possible", setup.repetitions),
            );
        }
        let work =
            [setup.repetitions, rows, columns, columns].into_iter().fold(setup.levels.len(), usize::saturating_mul);
        if faults.is_empty() && work > most_work {
            faults.push(
                "repetitions",
                format_args!(
                    "{} levels × {} repetitions × {rows} rows × {columns}² columns are {work}; a study allows at most \
                     {most_work}",
                    setup.levels.len(),
                    setup.repetitions
                ),
            );
        }
        if !faults.is_empty() {
            return Err(faults);
        }
        let mut study = Study {
            x: setup.x.into_values(),
            rows,
            columns,
            coefficients: setup.coefficients,
            deviation: Vec::new(),
            noise_sigma: setup.noise_sigma,
            levels: setup.levels,
            repetitions: setup.repetitions,
            seed: setup.seed,
        };
        let posted = study.coefficients.clone();
        if setup.scaling == ColumnScaling::UnitLength {
            study.divide_by_lengths();
        }
        study.deviation = (0..columns).map(|j| study.deviation_of(j)).collect();
        study.check_range(&posted, &mut faults);
        faults.into_result(study)
    }

    /// Squares of columns and coefficients must neither overflow nor vanish. A coefficient that
    /// does by the length of its column is that column's fault.
    fn check_range(&self, posted: &[f64], faults: &mut Faults) {
        const RANGE: std::ops::Range<f64> = 1e-140..1e140;
        let largest = |j: usize| self.column(j).map(f64::abs).fold(0.0, f64::max);
        let small = |coefficient: f64| coefficient.abs() < RANGE.end;
        let beyond: Vec<usize> = (0..self.columns)
            .filter(|&j| {
                largest(j) > 0.0 && !RANGE.contains(&largest(j)) || small(posted[j]) && !small(self.coefficients[j])
            })
            .collect();
        if !beyond.is_empty() {
            faults.push(
                "x",
                format_args!(
                    "squares in {} exceed the range of double precision: choose another unit",
                    columns_named(&beyond)
                ),
            );
        }
        for j in (0..self.columns).filter(|&j| !small(self.coefficients[j]) && !small(posted[j])) {
            faults.push(
                format_args!("coefficients[{j}]"),
                "the square of this coefficient exceeds the range of double precision: choose another unit",
            );
        }
    }

    fn column(&self, j: usize) -> impl Iterator<Item = f64> {
        self.x.iter().skip(j).step_by(self.columns).copied()
    }

    fn divide_by_lengths(&mut self) {
        for j in 0..self.columns {
            let largest = self.column(j).map(f64::abs).fold(0.0, f64::max);
            if largest > 0.0 {
                let length = largest * self.column(j).map(|x| (x / largest).powi(2)).sum::<f64>().sqrt();
                self.x.iter_mut().skip(j).step_by(self.columns).for_each(|x| *x /= length);
                self.coefficients[j] *= length;
            }
        }
    }

    /// √mean((x − x̄)²); exactly 0 for a column that does not vary.
    fn deviation_of(&self, j: usize) -> f64 {
        let mut column = self.column(j);
        let first = column.next().unwrap_or(0.0);
        if column.all(|x| x == first) {
            return 0.0;
        }
        let m = self.rows as f64;
        // about the first entry, so that a small spread on a large level keeps its digits
        let mean = self.column(j).map(|x| (x - first) / m).sum::<f64>();
        (self.column(j).map(|x| (x - first - mean).powi(2)).sum::<f64>() / m).sqrt()
    }
}

/// Columns by their numbers.
fn columns_named(columns: &[usize]) -> String {
    format!("{} {}", if columns.len() == 1 { "column" } else { "the columns" }, listed(columns))
}
