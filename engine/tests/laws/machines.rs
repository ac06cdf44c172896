//! Machines drawn at random, to be measured and corrected many times: shares no code with the
//! crate's simulation.

use crate::oracle::random::Random;
use flankfit_engine::gear::correction::{CorrectionSpec, Setting};

/// Distribution of simulated machines. Columns are products of Legendre polynomials over the nodes,
/// of RMS 1/√(2p+1)(2q+1) µm per unit.
#[derive(Clone, Copy, Debug)]
pub struct Plant {
    pub grid: [usize; 2],
    pub settings: usize,
    /// Distance of the last setting from a mixture of the second and the third; 1 if it is none.
    pub apart: f64,
    /// Errors of the settings, µm.
    pub off: f64,
    pub sigma: f64,
    /// Errors of the response: of single entries, or of whole columns.
    pub eta: f64,
    pub whole: bool,
}

/// A machine.
pub struct Machine {
    pub sensitivity: Vec<f64>,
    /// True response of the machine.
    pub response: Vec<f64>,
    /// Errors of its settings.
    pub off: Vec<f64>,
    sigma: f64,
    random: Random,
}

impl Plant {
    pub fn nodes(&self) -> usize {
        self.grid[0] * self.grid[1]
    }

    pub fn sensitivity(&self) -> Vec<f64> {
        let place = |i: usize, of: usize| 2.0 * i as f64 / (of - 1) as f64 - 1.0;
        let orders: Vec<(usize, usize)> =
            (0..).flat_map(|sum| (0..=sum).map(move |q| (sum - q, q))).take(self.settings).collect();
        let mut matrix = Vec::new();
        for i in 0..self.grid[0] {
            for j in 0..self.grid[1] {
                let (u, v) = (legendre(place(i, self.grid[0])), legendre(place(j, self.grid[1])));
                let mut row: Vec<f64> = orders.iter().map(|&(p, q)| u[p] * v[q]).collect();
                if self.apart < 1.0 {
                    row[self.settings - 1] = 0.6 * row[1] + 0.8 * row[2] + self.apart * row[self.settings - 1];
                }
                matrix.extend(row);
            }
        }
        matrix
    }

    /// The machine of a seed.
    pub fn machine(&self, seed: u64) -> Machine {
        let mut random = Random::new(seed);
        let off = (0..self.settings).map(|_| self.off * random.normal()).collect();
        self.machine_off(off, random)
    }

    /// A machine whose settings are off by `off`; its response is drawn.
    pub fn machine_off(&self, off: Vec<f64>, mut random: Random) -> Machine {
        let sensitivity = self.sensitivity();
        let columns = random.normals(self.settings);
        let response = sensitivity
            .iter()
            .enumerate()
            .map(|(at, x)| {
                x * (1.0 + self.eta * if self.whole { columns[at % self.settings] } else { random.normal() })
            })
            .collect();
        Machine { sensitivity, response, off, sigma: self.sigma, random }
    }

    pub fn asked(&self, machine: &Machine, measured: Vec<f64>) -> CorrectionSpec {
        let settings = (0..self.settings).map(|j| Setting::free(format!("s{j}"), "")).collect();
        CorrectionSpec {
            noise_sigma: Some(self.sigma),
            response_uncertainty: self.eta,
            ..CorrectionSpec::new(measured, machine.sensitivity.clone(), settings)
        }
    }
}

impl Machine {
    /// Returns the deviations that its settings cause, without noise.
    pub fn flank(&self) -> Vec<f64> {
        times(&self.response, &self.off)
    }

    pub fn measure(&mut self) -> Vec<f64> {
        let flank = self.flank();
        flank.iter().map(|x| x + self.sigma * self.random.normal()).collect()
    }

    pub fn change(&mut self, by: impl IntoIterator<Item = f64>) {
        self.off.iter_mut().zip(by).for_each(|(off, by)| *off += by);
    }
}

pub fn times(matrix: &[f64], x: &[f64]) -> Vec<f64> {
    matrix.chunks_exact(x.len()).map(|row| row.iter().zip(x).map(|(a, b)| a * b).sum()).collect()
}

/// P₀ … P₉ at x.
fn legendre(x: f64) -> Vec<f64> {
    let mut p = vec![1.0, x];
    for n in 1..9 {
        let n_f = n as f64;
        p.push(((2.0 * n_f + 1.0) * x * p[n] - n_f * p[n - 1]) / (n_f + 1.0));
    }
    p
}

/// The same for every seed below `count`, on two threads; in the order of the seeds.
pub fn each<T: Send>(count: u64, of: impl Fn(u64) -> T + Sync) -> Vec<T> {
    std::thread::scope(|scope| {
        let halves = [0..count / 2, count / 2..count].map(|seeds| scope.spawn(|| seeds.map(&of).collect::<Vec<T>>()));
        halves.into_iter().flat_map(|half| half.join().unwrap()).collect()
    })
}
