//! The iteration of a registration, and its answer.

use super::{
    Indistinguishable, Moved, Registering, Registration,
    columns::{Column, Freedom},
    misfit,
    pose::{Motion, Pose},
    start::{Start, nearest},
};
use crate::numerics::cancel::{self, Asking};
use crate::{
    estimation::{
        Faults, FitError, FitResult, FitSpec, Nodes, fit,
        result::Warning,
        spec::{Estimator, Include, Regularization},
        words::{Shown, counted},
    },
    gear::{
        Side,
        deviation::{
            Deviations, Direction, Node, Reference, Stray, Touch,
            foot::{foot, normal},
            measure::named,
        },
    },
    geometry::space::Vector,
};

/// Most iterations; with motions of some hundred µm and µrad four to six are enough.
pub const MOST_ITERATIONS: usize = 50;
/// A step that moves no point by more than this, µm, ends the iteration …
const STEP: f64 = 1e-9;
/// … or by more than this share of the gear's radius, as far as doubles tell its coordinates.
const RELATIVE_STEP: f64 = 32.0 * f64::EPSILON;

/// How far points may go to other flanks than before; later ones stay, lest they go to and fro.
const REASSIGNING: usize = 25;

/// How the part lies. Only the nodes that take part decide; all are carried back. Faults point to `/motions`, `/pivot_z_mm`, `/weight`, to `/points/i` for
/// node i, and where a fit has them. Points stay on the flanks that they are on.
pub fn register(reference: &Reference, deviations: &Deviations, asked: &Registering) -> Result<Registration, FitError> {
    registered(reference, deviations, asked, None)
}

/// The same where the part may lie anywhere: `deviations` are those of the points that `start` carried back, and points whose flank or tooth
/// is not told go to the nearest one anew after each step.
pub fn register_from(
    reference: &Reference,
    deviations: &Deviations,
    asked: &Registering,
    start: &Start,
) -> Result<Registration, FitError> {
    registered(reference, deviations, asked, Some(start))
}

fn registered(
    reference: &Reference,
    deviations: &Deviations,
    asked: &Registering,
    start: Option<&Start>,
) -> Result<Registration, FitError> {
    let freedom = Freedom::new(reference.gear, asked.motions)?;
    let mut part = Part::new(reference, deviations, asked, freedom, start)?;
    let pivot = part.pivot(asked)?;
    let mut pose = start.map_or(Pose { pivot, ..Pose::default() }, |start| start.pose.about(pivot));
    // what the fit finds, and regularises, counts from here
    let begun = part.freedom.coefficients(&pose);
    let mut p = begun.clone();
    let (mut iterations, mut converged) = (0, false);
    let last = loop {
        cancel::checkpoint();
        let reassigned = if iterations < REASSIGNING { part.reassign(&pose) } else { 0 };
        let state = part.at(&pose)?;
        let so_far: Vec<f64> = p.iter().zip(&begun).map(|(p, begun)| p - begun).collect();
        let heights: Vec<f64> =
            state.d.iter().zip(state.x.chunks_exact(p.len())).map(|(d, x)| d + dot(x, &so_far)).collect();
        let columns = &part.freedom.columns;
        let result = fit(&part.nodes(state.x.clone(), heights, columns)?, asked.spec)?;
        let next: Vec<f64> = result.coefficients.iter().zip(&begun).map(|(c, begun)| begun + c.value).collect();
        let step: Vec<f64> = next.iter().zip(&p).map(|(next, p)| next - p).collect();
        let moved = state.x.chunks_exact(p.len()).map(|x| dot(x, &step).abs()).fold(0.0, f64::max);
        part.freedom.set(&mut pose, &next, asked.spec.scaling);
        if !pose.is_sane() {
            return Err(FitError::NotConverged(
                "the registration ran away to tilts beyond 0.1 rad: free fewer motions, or regularise",
            ));
        }
        // doubles tell a coefficient of this size no finer
        let finest = RELATIVE_STEP * next.iter().fold(1e3 * reference.gear.tip_radius(), |most, p| most.max(p.abs()));
        (p, iterations) = (next, iterations + 1);
        converged = converged || (reassigned == 0 && moved <= STEP.max(finest));
        if converged || iterations == MOST_ITERATIONS {
            break result;
        }
    };
    part.answer(Found { pose, begun, iterations, converged }, last, asked)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The measured part.
struct Part<'a> {
    reference: &'a Reference<'a>,
    deviations: &'a Deviations,
    freedom: Freedom,
    start: Option<&'a Start>,
    /// Nodes that take part, and where they were measured.
    rows: Vec<(usize, Vector)>,
    /// Tooth and flank of every row.
    flank: Vec<(u32, Side)>,
    weight: Option<Vec<f64>>,
}

/// Where the iteration ended.
struct Found {
    pose: Pose,
    /// Coefficients of the columns where it began.
    begun: Vec<f64>,
    iterations: usize,
    converged: bool,
}

/// Rows of X and normal deviations (µm) at a pose.
struct State {
    x: Vec<f64>,
    d: Vec<f64>,
}

impl<'a> Part<'a> {
    fn new(
        reference: &'a Reference<'a>,
        deviations: &'a Deviations,
        asked: &Registering,
        freedom: Freedom,
        start: Option<&'a Start>,
    ) -> Result<Self, FitError> {
        let nodes = &deviations.nodes;
        if let Some(weight) = asked.weight.filter(|weight| weight.len() != nodes.len()) {
            let detail = format!("{}, but {} would match the points", weight.len(), nodes.len());
            return Err(Faults::one("/weight", detail).into());
        }
        let mut faults = Faults::default();
        let mut rows = Vec::with_capacity(nodes.len());
        let mut weights = asked.weight.map(|_| Vec::with_capacity(nodes.len()));
        for (i, _) in nodes.iter().enumerate().filter(|(_, node)| node.counts()).asking(500) {
            let weight = asked.weight.map_or(1.0, |weight| weight[i]);
            if !(weight >= 0.0 && weight.is_finite()) {
                faults.push(format!("/weight/{i}"), format!("{} is not a finite number of at least 0", Shown(weight)));
            }
            if weight > 0.0
                && let Some(point) = deviations.point(reference, i)
            {
                if point.iter().all(|x| x.is_finite()) {
                    rows.push((i, start.map_or(point, |start| start.pose.apply(&point))));
                    weights.iter_mut().for_each(|weights| weights.push(weight));
                } else {
                    faults.push(format!("/points/{i}"), "the modification has no value here");
                }
            }
        }
        if faults.is_empty() && rows.len() < freedom.columns.len() {
            let (points, motions) = (rows.len(), freedom.columns.len());
            let points = counted(points, "measured point takes", "measured points take");
            let motions = counted(motions, "motion", "motions");
            faults.push("/points", format!("{points} part, too few for {motions}"));
        }
        faults.into_result(())?;
        let flank = rows.iter().map(|(i, _)| (nodes[*i].tooth, nodes[*i].side)).collect();
        Ok(Part { reference, deviations, freedom, start, rows, flank, weight: weights })
    }

    /// z of the pivot, mm.
    fn pivot(&self, asked: &Registering) -> Result<f64, Faults> {
        match asked.pivot {
            Some(z) if z.is_finite() => Ok(z),
            Some(_) => Err(Faults::one("/pivot_z_mm", "the number is not finite in double precision")),
            None => {
                let z = self.rows.iter().map(|(i, _)| self.deviations.nodes[*i].z);
                let [low, high] = z.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], z| [a.min(z), b.max(z)]);
                Ok(0.5 * (low + high))
            }
        }
    }

    /// A point carried back: its node, with the deviation along the normal.
    fn carried(&self, (tooth, side): (u32, Side), point: &Vector) -> Result<Node, Stray> {
        let gear = self.reference.gear;
        let foot = foot(gear, side, Some(tooth), point, self.deviations.ball_radius)?;
        self.reference.node(&foot, Direction::Normal)
    }

    /// The flank of node `i` that is nearest to the point carried back, where it is not told; `None` where it is, or where there is none.
    fn nearest(&self, i: usize, back: &Vector) -> Option<(u32, Side)> {
        let touch = self.start?.touches.get(i)?;
        // normals were given to tell sides, and have told them
        let side = touch.side.or_else(|| touch.normal.map(|_| self.deviations.nodes[i].side));
        if side.is_some() && touch.tooth.is_some() {
            return None;
        }
        let open = Touch { point: *back, tooth: touch.tooth, side, normal: None };
        nearest(self.reference.gear, &open, self.deviations.ball_radius).map(|foot| (foot.tooth, foot.side))
    }

    /// Sends every row to the nearest flank that it may belong to; how many went to another one.
    fn reassign(&mut self, pose: &Pose) -> usize {
        let undoing = pose.undoing();
        let mut changed = 0;
        for (k, (i, point)) in self.rows.iter().enumerate().asking(1000) {
            if let Some(flank) = self.nearest(*i, &undoing.point(point)).filter(|flank| *flank != self.flank[k]) {
                self.flank[k] = flank;
                changed += 1;
            }
        }
        changed
    }

    fn at(&self, pose: &Pose) -> Result<State, Faults> {
        self.with_columns(pose, &self.freedom.columns)
    }

    fn with_columns(&self, pose: &Pose, columns: &[Column]) -> Result<State, Faults> {
        let undoing = pose.undoing();
        let mut faults = Faults::default();
        let mut state =
            State { x: Vec::with_capacity(self.rows.len() * columns.len()), d: Vec::with_capacity(self.rows.len()) };
        for ((i, point), flank) in self.rows.iter().zip(&self.flank).asking(500) {
            match self.carried(*flank, &undoing.point(point)) {
                Ok(carried) => {
                    let normal =
                        normal(self.reference.gear, carried.tooth, carried.side, carried.roll_length, carried.z);
                    let other = undoing.columns(point, &normal);
                    state.x.extend(columns.iter().map(|column| self.freedom.entry(*column, carried.side, &other)));
                    state.d.push(carried.deviation);
                }
                Err(stray) => {
                    let detail = format!("carried back to {} it is lost: {stray}", named(*flank));
                    faults.push(format!("/points/{i}"), detail);
                }
            }
        }
        faults.into_result(state)
    }

    fn nodes(&self, x: Vec<f64>, heights: Vec<f64>, columns: &[Column]) -> Result<Nodes, Faults> {
        let names = columns.iter().map(|column| column.name().to_owned()).collect();
        Nodes::matrix(x, columns.len(), heights, Some(names), self.weight.clone())
    }

    fn answer(
        &self,
        Found { pose, begun, iterations, converged }: Found,
        last: FitResult,
        asked: &Registering,
    ) -> Result<Registration, FitError> {
        let mut warnings = Vec::new();
        if !converged {
            warnings.push(Warning {
                code: "registration_not_converged",
                message: format!("the motions still changed after {iterations} iterations"),
            });
        }
        let every_motion = if self.freedom.is_whole() { None } else { Some(self.every_motion(&pose, asked.spec)?) };
        let dependencies = &every_motion.as_ref().unwrap_or(&last).collinearity.near_dependencies;
        let indistinguishable = dependencies
            .iter()
            .map(|near| Indistinguishable {
                motions: near.terms.iter().filter_map(|term| Motion::named(term)).collect(),
                condition_index: near.condition_index,
                sentence: near.sentence.clone(),
            })
            .collect();
        if !self.freedom.is_whole() {
            warnings.push(self.undetermined());
        }
        let dependent = Self::dependent(&last);
        if !dependent.is_empty() {
            let names: Vec<&str> = dependent.iter().map(|motion| motion.name()).collect();
            let message = format!(
                "{}: these points do not tell them apart; their joint effect is shared between them by minimum norm, and none has a standard \
                 error",
                names.join(", ")
            );
            warnings.push(Warning { code: "motions_indistinguishable", message });
        }
        let deviations = self.carried_back(&pose, &mut warnings);
        if let Some(start) = self.start {
            warnings.extend(misfit::of_start(self.reference.gear, start, &deviations));
        }
        let rows: Vec<usize> = self.rows.iter().map(|(i, _)| *i).collect();
        warnings.extend(misfit::of_part(self.reference.gear, &deviations, &rows));
        Ok(Registration {
            motions: self.moved(&pose, &last, asked.spec, &begun),
            pose,
            rms_before: self.rms_before(&deviations),
            rms_after: deviations.rms().unwrap_or_default(),
            iterations,
            converged,
            indistinguishable,
            fit: last,
            every_motion,
            rows,
            deviations,
            warnings,
        })
    }

    /// Of the points as they were measured, against the flanks that they are found to belong to.
    fn rms_before(&self, after: &Deviations) -> f64 {
        let Some(start) = self.start else {
            // at least one node takes part
            return self.deviations.rms().unwrap_or_default();
        };
        let scale = self.deviations.direction.from_normal(self.reference.gear);
        let (mut count, mut sum) = (0.0, 0.0);
        for (i, node) in after.nodes.iter().enumerate().filter(|(_, node)| node.counts()).asking(1000) {
            if let Some(point) = self.deviations.point(self.reference, i)
                && let Ok(before) = self.carried((node.tooth, node.side), &start.pose.apply(&point))
            {
                (count, sum) = (count + 1.0, sum + (scale * before.deviation).powi(2));
            }
        }
        if count > 0.0 { (sum / count).sqrt() } else { 0.0 }
    }

    /// Least squares with a column for every motion.
    fn every_motion(&self, pose: &Pose, spec: &FitSpec) -> Result<FitResult, FitError> {
        let columns: Vec<Column> = self.freedom.motions.iter().map(|motion| Column::Motion(*motion)).collect();
        let State { x, d } = self.with_columns(pose, &columns)?;
        let values: Vec<f64> = self.freedom.motions.iter().map(|motion| pose.get(*motion)).collect();
        let heights = d.iter().zip(x.chunks_exact(columns.len())).map(|(d, x)| d + dot(x, &values)).collect();
        let plain = FitSpec {
            regularization: Regularization::None,
            estimator: Estimator::LeastSquares,
            include: Include::default(),
            ..spec.clone()
        };
        fit(&self.nodes(x, heights, &columns)?, &plain)
    }

    fn undetermined(&self) -> Warning {
        let message = if self.freedom.columns.contains(&Column::Screw) {
            "rotation and axial_shift: a screw motion carries the flanks of a helical gear into themselves, so that no points of them tell \
             the two apart; their joint effect is shared between them by minimum norm, and neither has a standard error. Free only one of \
             them to have all of it there"
        } else {
            "axial_shift: the flanks of a spur gear are the same along the axis, so that no points of them tell it; it is left at 0"
        };
        Warning { code: "motions_indistinguishable", message: message.into() }
    }

    /// The motions that these points do not tell from others, though points elsewhere could.
    fn dependent(last: &FitResult) -> Vec<Motion> {
        let exact = last.collinearity.near_dependencies.iter().filter(|near| near.condition_index.is_none());
        let terms = exact.flat_map(|near| &near.terms);
        terms.filter_map(|term| Motion::named(term)).collect()
    }

    fn moved(&self, pose: &Pose, last: &FitResult, spec: &FitSpec, begun: &[f64]) -> Vec<Moved> {
        let mut start = Pose::default();
        self.freedom.set(&mut start, begun, spec.scaling);
        let dependent = Self::dependent(last);
        let of = |motion: Motion| {
            self.freedom.columns.iter().zip(&last.coefficients).find_map(|(column, coefficient)| {
                let shares = self.freedom.shares(*column, spec.scaling);
                shares.into_iter().find(|(m, _)| *m == motion).map(|(_, share)| (coefficient, share))
            })
        };
        self.freedom
            .motions
            .iter()
            .map(|&motion| {
                let determined = self.freedom.tells(motion) && !dependent.contains(&motion);
                // what is shared between motions says nothing of one of them
                let told = of(motion).filter(|_| determined);
                Moved {
                    motion,
                    value: pose.get(motion),
                    // −0 is 0
                    start: start.get(motion) + 0.0,
                    std_error: told.and_then(|(c, share)| c.std_error.map(|error| error * share.abs())),
                    bias_bound: told.map(|(c, _)| c.bias_bound),
                    determined,
                }
            })
            .collect()
    }

    /// Every defined node carried back, in the direction of the deviations given.
    fn carried_back(&self, pose: &Pose, warnings: &mut Vec<Warning>) -> Deviations {
        let undoing = pose.undoing();
        let mut back = self.deviations.clone();
        let scale = back.direction.from_normal(self.reference.gear);
        let mut lost = Vec::new();
        for (i, node) in back.nodes.iter_mut().enumerate().asking(1000) {
            let Some(point) = self.deviations.point(self.reference, i) else { continue };
            let point = undoing.point(&self.start.map_or(point, |start| start.pose.apply(&point)));
            let flank = self.nearest(i, &point).unwrap_or((node.tooth, node.side));
            match self.carried(flank, &point) {
                Ok(carried) => *node = Node { deviation: carried.deviation * scale, within: node.within, ..carried },
                Err(stray) => {
                    *node = Node { roll_length: f64::NAN, z: f64::NAN, deviation: f64::NAN, ..*node };
                    lost.push((i, stray));
                }
            }
        }
        if let Some((first, stray)) = lost.first() {
            let count = counted(lost.len(), "node has", "nodes have");
            warnings.push(Warning {
                code: "nodes_lost",
                message: format!(
                    "{count} no place on the flank once carried back and are undefined; the first is {first}: {stray}"
                ),
            });
        }
        back.strays.extend(lost);
        back
    }
}
