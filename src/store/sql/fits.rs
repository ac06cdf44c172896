//! Fits of an iteration, and the chosen one.

use std::collections::VecDeque;

use futures_util::TryStreamExt as _;

use super::{
    audit, gone,
    keys::{FitPlace, StoredFit},
    lists::{Counted, Listed, page},
    locate,
    prelude::*,
    subject,
};

/// The columns of [`Figures`].
macro_rules! figure_columns {
    () => {
        "lambda_star, criterion, scheme, count, condition, regularized_condition, bias_norm, bias_sharp_bound, rms, \
         max_abs"
    };
}
pub(super) use figure_columns;

from_row! {
    Figures {
        lambda_star, criterion, scheme, count, condition, regularized_condition, bias_norm, bias_sharp_bound, rms,
        max_abs,
    }
    Event { reason, by = "actor", created_at }
    FitRecord { @event, id, spec, result, flank = "flank_figures", chosen }
    FitSummary { @event, @figures, id, chosen, chosen_by, flank = "flank_figures" }
    Choice { @event, fit_id }
    DecisionEvent { @event, decision, concession }
}

row! {
    pub struct TracedFitRow {
        @summary: FitSummary,
        coefficients: Option<Arc<str>>,
        prior: Option<Arc<str>>,
        /// Present if neither is stored separately; empty if it was purged.
        result: Option<Arc<str>>,
    }
}

impl From<TracedFitRow> for TracedFit {
    fn from(TracedFitRow { summary, coefficients, prior, result }: TracedFitRow) -> Self {
        let told = result.as_ref().map_or_else(Told::default, |result| Told::of(result));
        let text = |kept: Option<Arc<str>>, found: Option<&str>| kept.as_deref().or(found).map(str::to_owned);
        TracedFit {
            summary,
            coefficients: text(coefficients, told.coefficients).unwrap_or_else(|| "[]".to_owned()),
            prior: text(prior, told.prior),
        }
    }
}

/// The position of the chosen fit of the iteration that is the statement's first two values.
macro_rules! chosen_fit {
    () => {
        "(SELECT fit FROM fit_choices WHERE job = $1 AND number = $2 ORDER BY position DESC LIMIT 1)"
    };
}

/// The columns of a [`FitSummary`].
macro_rules! summary_columns {
    () => {
        concat!(
            "id, reason, actor, created_at, position = ",
            chosen_fit!(),
            " AS chosen, CASE WHEN position = ",
            chosen_fit!(),
            " THEN (SELECT actor FROM fit_choices WHERE job = $1 AND number = $2 ORDER BY position DESC LIMIT 1) END
             AS chosen_by, flank_figures, ",
            figure_columns!()
        )
    };
}

/// How many fits the iteration has that is the statement's first two values.
macro_rules! total {
    () => {
        "(SELECT count(*) FROM fits WHERE job = $1 AND number = $2) AS total, "
    };
}

/// Returns the statements that store fits, each noted in the entry at its place.
pub fn insertion<'a>(db: &Db, fits: &[(FitPlace, &'a NewFit)], entries: &mut [Draft]) -> Vec<Ready<'a>> {
    let mut rows = Vec::with_capacity(fits.len());
    for (FitPlace { job, number, position }, fit) in fits.iter().copied() {
        let Computed { spec, result, figures, flank } = &fit.computed;
        let beside = result.kept_parts();
        rows.push(vec![
            job.into(),
            number.into(),
            position.into(),
            fit.id.into(),
            fit.event.reason.as_deref().into(),
            fit.event.by.as_deref().into(),
            fit.event.created_at.into(),
            figures.lambda_star.into(),
            figures.criterion.into(),
            figures.scheme.into(),
            figures.count.into(),
            figures.condition.into(),
            figures.regularized_condition.into(),
            figures.bias_norm.into(),
            figures.bias_sharp_bound.into(),
            figures.rms.into(),
            figures.max_abs.into(),
            Value::document(spec),
            Value::Document(Some(EncodedText::clone(result))),
            flank.as_deref().into(),
            Value::Document(beside.coefficients.clone()),
            Value::Document(beside.prior.clone()),
        ]);
    }
    let columns = concat!(
        "job, number, position, id, reason, actor, created_at, ",
        figure_columns!(),
        ", spec, result, flank_figures, coefficients, prior"
    );
    audit::insertion(db, "fits", columns, rows, entries)
}

/// Returns the last fits of an iteration, and how many come before them.
pub async fn last(db: &mut Db, job: Uuid, number: u32) -> Outcome<(Vec<FitSummary>, u64)> {
    let sql = concat!(
        "SELECT ",
        total!(),
        summary_columns!(),
        " FROM fits WHERE job = $1 AND number = $2 ORDER BY position DESC LIMIT $3"
    );
    locate::last(db, sql, job, number).await
}

/// Returns the last choices of an iteration, and how many come before them.
pub async fn last_choices(db: &mut Db, job: Uuid, number: u32) -> Outcome<(Vec<Choice>, u64)> {
    let sql = "SELECT (SELECT count(*) FROM fit_choices WHERE job = $1 AND number = $2) AS total,
                      f.id AS fit_id, c.reason, c.actor, c.created_at
               FROM fit_choices c JOIN fits f ON f.job = c.job AND f.number = c.number AND f.position = c.fit
               WHERE c.job = $1 AND c.number = $2 ORDER BY c.position DESC LIMIT $3";
    locate::last(db, sql, job, number).await
}

/// Returns the last fits of an iteration with their coefficients, as many as `text` holds the
/// coefficients of and at least one, and how many come before them.
pub async fn last_with_coefficients(
    db: &mut Db,
    job: Uuid,
    number: u32,
    text: usize,
) -> Outcome<(Vec<TracedFit>, u64)> {
    // Stored coefficients are counted by their bytes here, perhaps compressed, and no result up to
    // 64 kB has any, so at most a few times `text` and a hundred such results are sent.
    let sql = concat!(
        "SELECT * FROM (SELECT ",
        total!(),
        summary_columns!(),
        ", coefficients, prior, CASE WHEN coefficients IS NULL AND prior IS NULL THEN result END AS result,
           position, coalesce(sum(length(coefficients)) OVER
               (ORDER BY position DESC ROWS BETWEEN UNBOUNDED PRECEDING AND 1 PRECEDING), 0) AS after
           FROM fits WHERE job = $1 AND number = $2 ORDER BY position DESC LIMIT $3) AS newest
         WHERE after <= $4 ORDER BY position DESC"
    );
    let mut rows = db.each::<Counted<TracedFitRow>>(sql, args![job, number, MAX_LISTED, text])?;
    let (mut fits, mut length, mut total) = (VecDeque::<TracedFit>::new(), 0, 0_u64);
    while let Some(row) = rows.try_next().await? {
        let fit = TracedFit::from(row.row);
        length += fit.coefficients.len();
        if length > text && !fits.is_empty() {
            break;
        }
        total = row.total;
        fits.push_front(fit);
    }
    let earlier = total.saturating_sub(fits.len() as u64);
    Ok((fits.into(), earlier))
}

pub async fn fits(
    db: &mut Db,
    caller: &Caller,
    job: &Uuid,
    number: &u32,
    PageRequest { limit, after }: &PageRequest,
) -> Outcome<Page<FitSummary>> {
    locate::iteration(db, &caller.tenant, *job, *number).await?;
    let sql = concat!(
        "SELECT position AS place, ",
        summary_columns!(),
        " FROM fits WHERE job = $1 AND number = $2 AND position > $3 ORDER BY position LIMIT $4"
    );
    let after = after.map_or(0, |cursor| cursor.number());
    let rows: Vec<Listed<FitSummary>> = db.all(sql, args![job, *number, after, i64::from(*limit) + 1]).await?;
    Ok(page(rows, *limit))
}

pub async fn fit(db: &mut Db, caller: &Caller, job: &Uuid, number: &u32, fit: &Uuid) -> Outcome<FitRecord> {
    locate::iteration(db, &caller.tenant, *job, *number).await?;
    let sql = concat!(
        "SELECT id, reason, actor, created_at, position = ",
        chosen_fit!(),
        " AS chosen, flank_figures, spec, result FROM fits WHERE job = $1 AND number = $2 AND id = $3"
    );
    let fit: Option<FitRecord> = db.maybe(sql, args![job, *number, fit]).await?;
    match fit.ok_or(RepositoryError::NotFound(Resource::Fit))? {
        fit if fit.result.is_empty() => Err(gone::refusal(db, *job).await),
        fit => Ok(fit),
    }
}

/// Adds a fit to those of an iteration; returns its place.
pub async fn insert_next(db: &mut Db, job: Uuid, number: u32, fit: &NewFit, entry: &mut Draft) -> Outcome<FitPlace> {
    let sql = "SELECT max(position) FROM fits WHERE job = $1 AND number = $2";
    let last: i64 = db.one(sql, args![job, number]).await?;
    let place = FitPlace { job, number, position: last + 1 };
    db.run_together(insertion(db, &[(place, fit)], std::slice::from_mut(entry))).await?;
    Ok(place)
}

/// Stores the choice of a fit.
pub async fn insert_choice(db: &mut Db, fit: FitPlace, choice: &Choice, entry: &mut Draft) -> Outcome<()> {
    let event = &choice.event;
    db.run(
        "INSERT INTO fit_choices (job, number, position, fit, reason, actor, created_at)
         SELECT $1, $2, coalesce(max(position), 0) + 1, $3, $4, $5, $6
         FROM fit_choices WHERE job = $1 AND number = $2",
        args![fit.job, fit.number, fit.position, event.reason.as_deref(), event.by.as_deref(), event.created_at],
    )
    .await?;
    let last = "job = $1 AND number = $2 ORDER BY position DESC LIMIT 1";
    entry.note_stored(db, "fit_choices", last, args![fit.job, fit.number]).await
}

pub async fn insert_fit(tx: &mut Tx<'_>, write: &InsertFit) -> Outcome<Stored> {
    let (InsertFit { job, number, fit, .. }, tenant) = (write, tx.tenant());
    let version = locate::version(tx.db(), tenant, *job, *number).await?;
    tx.refuse_taken()?;
    let mut entry = tx.draft(*job, Action::AddFit, subject::fit(*job, *number, fit.id))?;
    let place = insert_next(tx.db(), *job, *number, fit, &mut entry).await?;
    tx.enter(entry);
    let stored = Stored { number: *number, version: version + 1 };
    let stored_fit = StoredFit { place, result: &fit.computed.result };
    tx.keep(&write.receipt, stored, Some(stored_fit), fit.event.created_at);
    Ok(stored)
}

pub async fn choose(tx: &mut Tx<'_>, write: &Choose) -> Outcome<Stored> {
    let (Choose { job, number, choice, precondition }, tenant) = (write, tx.tenant());
    let version = locate::version(tx.db(), tenant, *job, *number).await?;
    precondition.check(version)?;
    let sql = "SELECT position FROM fits WHERE job = $1 AND number = $2 AND id = $3";
    let position: Option<i64> = tx.db().first(sql, args![job, *number, choice.fit_id]).await?;
    let position = position.ok_or(RepositoryError::ForeignFit(choice.fit_id))?;
    let sql = "SELECT fit, reason FROM fit_choices WHERE job = $1 AND number = $2 ORDER BY position DESC LIMIT 1";
    let latest: Option<(i64, Option<String>)> = tx.db().maybe(sql, args![job, *number]).await?;
    if latest.is_some_and(|(fit, reason)| (fit, &reason) == (position, &choice.event.reason)) {
        return Ok(Stored { number: *number, version });
    }
    let mut entry = tx.draft(*job, Action::ChooseFit, subject::fit(*job, *number, choice.fit_id))?;
    insert_choice(tx.db(), FitPlace { job: *job, number: *number, position }, choice, &mut entry).await?;
    tx.enter(entry);
    Ok(Stored { number: *number, version: version + 1 })
}
