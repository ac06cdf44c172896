//! Steps of the demonstration, through the HTTP interface alone.

use std::io::{self, Write};

use flankfit_engine::estimation::{
    result::Choice,
    spec::{ChosenBy, Criterion},
};
use serde_json::{Value, json};

use super::{
    client::Client,
    node_file::{NodeSet, Units},
    report,
};
use crate::{
    api::{
        fits::answer::FitResultBody,
        jobs::{
            iterations::{IterationFitBody, NewIterationBody},
            job::JobBody,
            trace::TraceBody,
        },
    },
    cli::CommandError,
};

/// Prints the fits of iterations as tables.
pub struct Story<'a, W: Write> {
    pub client: &'a Client,
    pub out: W,
}

impl<W: Write> Story<'_, W> {
    /// Measures and fits nodes of the caller's own, refits them with another λ*, and chooses.
    /// Returns the path of the job.
    pub fn run(&mut self, set: &NodeSet) -> Result<String, CommandError> {
        let created: JobBody = self.client.post("/v1/jobs", &json!({"name": set.name}))?;
        let path = format!("/v1/jobs/{}", created.id);
        self.heading(&format!("Job: {}", set.name))?;
        writeln!(self.out, "  {}", self.client.url(&path))?;
        let mut body = set.request.clone();
        if let Some(object) = body.as_object_mut() {
            object.entry("instrument").or_insert_with(|| "gear tester".into());
        }
        let iteration: NewIterationBody = self.client.post(&format!("{path}/iterations"), &body)?;
        self.print_iteration(&path, &iteration, set)?;
        writeln!(
            self.out,
            "\n  The decision is left to you: PATCH {}",
            self.client.url(&format!("{path}/iterations/{}", iteration.posted.measured.number))
        )?;
        self.trace(&path)?;
        Ok(path)
    }

    /// Prints the fit of an iteration, and refits its nodes by another criterion.
    pub fn print_iteration(
        &mut self,
        job: &str,
        iteration: &NewIterationBody,
        set: &NodeSet,
    ) -> Result<(), CommandError> {
        self.heading(&format!("Iteration {}: {}", iteration.posted.measured.number, set.name))?;
        write!(self.out, "{}", set.report)?;
        let fit = chosen(iteration)?;
        self.show_fit(&fit.result.value()?, set.units)?;
        self.refit(job, iteration, fit, &set.request)
    }

    /// Prints what was recorded of the job.
    pub fn trace(&mut self, job: &str) -> Result<(), CommandError> {
        let trace: TraceBody = self.client.get(&format!("{job}/trace"))?;
        self.heading("Trace of the job")?;
        write!(self.out, "{}", report::trace(&trace))?;
        Ok(())
    }

    fn heading(&mut self, text: &str) -> io::Result<()> {
        writeln!(self.out, "\n{text}")
    }

    fn show_fit(&mut self, fit: &FitResultBody, units: Units) -> io::Result<()> {
        self.heading("Coefficients")?;
        write!(self.out, "{}", report::coefficients(fit, units))?;
        self.heading("Spectrum of the scaled Fisher information matrix")?;
        write!(self.out, "{}", report::spectrum(fit))?;
        self.heading("λ* as each criterion would choose it")?;
        write!(self.out, "{}", report::choices(fit))?;
        self.heading("Collinearity")?;
        write!(self.out, "{}", report::collinearity(fit))?;
        let warnings = report::warnings(fit);
        if !warnings.is_empty() {
            self.heading("Warnings")?;
            write!(self.out, "{warnings}")?;
        }
        Ok(())
    }

    /// Refits the stored nodes by another criterion and lets the fit with the smaller predicted
    /// error stand.
    fn refit(
        &mut self,
        job: &str,
        first: &NewIterationBody,
        fit: &IterationFitBody,
        request: &Value,
    ) -> Result<(), CommandError> {
        let result = fit.result.value()?;
        let other = best_other(&result).and_then(|criterion| {
            with_criterion(request.get("regularization"), criterion.name()).map(|changed| (criterion, changed))
        });
        let Some((criterion, regularization)) = other else {
            writeln!(self.out, "\n  No criterion chooses another λ* here; the fit is kept as it is.")?;
            return Ok(());
        };
        let mut body = request.clone();
        if let Some(object) = body.as_object_mut() {
            object.retain(|key, _| {
                !["nodes", "flank", "tooth", "axes", "measured_at", "instrument", "operator", "note"]
                    .contains(&key.as_str())
            });
            object.insert("regularization".into(), regularization);
            // `folds` is valid only with cross-validation
            if criterion != ChosenBy::Criterion(Criterion::BlockedCv) && !object.contains_key("select") {
                object.remove("folds");
            }
            object.insert("reason".into(), format!("what {} makes of it", criterion.name()).into());
        }
        let iteration = format!("{job}/iterations/{}", first.posted.measured.number);
        let refit: IterationFitBody = self.client.post(&format!("{iteration}/fits"), &body)?;

        let refitted = refit.result.value()?;
        let current = result.regularization.criterion.unwrap_or(ChosenBy::LeastSquares);
        let errors = (predicted_error(&refitted, criterion), predicted_error(&result, current));
        let (better, reason) = match errors {
            (Some(refitted), Some(first)) if refitted < first => {
                (&refit, "smaller predicted error of the coefficients")
            }
            _ => (fit, "the refit promises no smaller error of the coefficients"),
        };
        let _: Value =
            self.client.put(&format!("{iteration}/chosen-fit"), &json!({"fit_id": better.id, "reason": reason}))?;
        self.heading(&format!("Refit of the stored nodes by {}, and the choice", criterion.name()))?;
        write!(self.out, "{}", report::fits(&[(fit.id, &result), (refit.id, &refitted)], better.id))?;
        Ok(())
    }
}

/// Returns the fit that an iteration was stored with.
pub fn chosen(iteration: &NewIterationBody) -> Result<&IterationFitBody, CommandError> {
    let number = iteration.posted.measured.number;
    iteration.fits.first().ok_or_else(|| format!("iteration {number} was answered without a fit").into())
}

/// Returns, of the criteria whose λ* differs from the fit's own by more than a tenth, the one
/// with the smallest predicted error.
fn best_other(fit: &FitResultBody) -> Option<ChosenBy> {
    let current = fit.regularization.lambda_star;
    let differs = |other: f64| current.is_none_or(|current| (other - current).abs() > 0.1 * current);
    let others = fit.regularization.choices.iter().filter(|choice| choice.lambda_star.is_some_and(differs));
    let error = |choice: &Choice| choice.predicted_mse.unwrap_or(f64::INFINITY);
    others.min_by(|a, b| error(a).total_cmp(&error(b))).map(|choice| choice.criterion)
}

fn predicted_error(fit: &FitResultBody, criterion: ChosenBy) -> Option<f64> {
    fit.regularization.choices.iter().find(|choice| choice.criterion == criterion)?.predicted_mse
}

/// Returns the requested regularisation with another criterion for its parameter; `None` if it has
/// no parameter that a criterion could select.
fn with_criterion(regularization: Option<&Value>, criterion: &str) -> Option<Value> {
    let plain = || json!({"type": "spectral"});
    let mut changed = regularization.filter(|value| !value.is_null()).cloned().unwrap_or_else(plain);
    if changed["type"] == "none" {
        changed = plain();
    }
    let key = match changed["type"].as_str()? {
        "spectral" => "lambda_star",
        "ridge" | "tikhonov" | "attraction" => "parameter",
        _ => return None,
    };
    changed[key] = json!({"criterion": criterion});
    Some(changed)
}
