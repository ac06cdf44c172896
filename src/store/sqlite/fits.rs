//! Fits of an iteration, and the chosen one.

use sqlx::{Sqlite, SqliteConnection, SqlitePool, query::Query, sqlite::SqliteArguments};

use super::{
    answers::{self, StoredFit},
    audit,
    document::result_column,
    gone,
    locate::{self, IterationVersion, within},
    time,
};
use crate::{
    jobs::{
        Caller, Choice, Computed, EncodedResult, EncodedText, FitRecord, FitSummary, KeptBeside, MAX_LISTED, NewFit,
        Page, PageRequest, RepositoryError, Resource, Stored, TracedFit, audit::Action,
    },
    store::shared::{
        Asked, ChoiceRow, Choose, Counted, FitRow, FitSummaryRow, GetFit, InsertFit, Latest, ListFits, Listed, Outcome,
        Read, TracedFitRow, Write, figure_columns, page, target, told,
    },
};

/// The row of the fit that stands, of the iteration that is the statement's first variable.
macro_rules! chosen_fit {
    () => {
        "(SELECT fit FROM fit_choices WHERE iteration = ?1 ORDER BY position DESC LIMIT 1)"
    };
}

/// The columns of a [`FitSummaryRow`].
macro_rules! summary_columns {
    () => {
        concat!(
            "id, reason, actor, created_at, seq = ",
            chosen_fit!(),
            " AS chosen, iif(seq = ",
            chosen_fit!(),
            ", (SELECT actor FROM fit_choices WHERE iteration = ?1 ORDER BY position DESC LIMIT 1), NULL) AS chosen_by, flank_figures, ",
            figure_columns!()
        )
    };
}

/// The columns of a fit that [`bind`] gives values, in its order.
macro_rules! fit_columns {
    () => {
        concat!(
            "id, iteration, reason, actor, created_at, ",
            figure_columns!(),
            ", spec, flank_figures, result, frame, coefficients, prior"
        )
    };
}
pub(super) use fit_columns;

/// Binds the [`fit_columns`] of a fit of the iteration that is row `iteration`.
pub fn bind<'q>(
    query: Query<'q, Sqlite, SqliteArguments>,
    iteration: i64,
    fit: &'q NewFit,
) -> Query<'q, Sqlite, SqliteArguments> {
    let Computed { spec, result, figures, flank } = &fit.computed;
    let query = query
        .bind(fit.id)
        .bind(iteration)
        .bind(fit.event.reason.as_deref())
        .bind(fit.event.by.as_deref())
        .bind(time::to_text(fit.event.created_at))
        .bind(figures.lambda_star)
        .bind(figures.criterion)
        .bind(figures.scheme)
        .bind(figures.count)
        .bind(figures.condition)
        .bind(figures.regularized_condition)
        .bind(figures.bias_norm)
        .bind(figures.bias_sharp_bound)
        .bind(figures.rms)
        .bind(figures.max_abs)
        .bind(spec.clone())
        .bind(flank.clone());
    bind_result(query, result)
}

/// Binds the columns of a result: its text; or nothing, a frame, and what is kept beside it.
pub fn bind_result<'q>(
    query: Query<'q, Sqlite, SqliteArguments>,
    result: &EncodedResult,
) -> Query<'q, Sqlite, SqliteArguments> {
    let Some(frame) = result.frame() else {
        return query.bind(result.text().clone()).bind(None::<&[u8]>).bind(None::<&str>).bind(None::<&str>);
    };
    let told = |text: &Option<EncodedText>| text.as_ref().map(|text| text.text().clone());
    let KeptBeside { coefficients, prior } = result.kept_beside();
    query.bind("").bind(frame.clone()).bind(told(coefficients)).bind(told(prior))
}

/// The last fits of an iteration, and how many stand before them.
pub async fn last(db: &mut SqliteConnection, iteration: i64) -> Outcome<(Vec<FitSummary>, u64)> {
    locate::last::<FitSummaryRow, _>(
        db,
        concat!(
            "SELECT (SELECT count(*) FROM fits WHERE iteration = ?1) AS total, ",
            summary_columns!(),
            " FROM fits WHERE iteration = ?1 ORDER BY seq DESC LIMIT ?2"
        ),
        iteration,
    )
    .await
}

/// The last choices of an iteration, and how many stand before them.
pub async fn last_choices(db: &mut SqliteConnection, iteration: i64) -> Outcome<(Vec<Choice>, u64)> {
    locate::last::<ChoiceRow, _>(
        db,
        "SELECT (SELECT count(*) FROM fit_choices WHERE iteration = ?1) AS total,
                f.id AS fit_id, c.reason AS reason, c.actor AS actor, c.created_at AS created_at
         FROM fit_choices c JOIN fits f ON f.seq = c.fit WHERE c.iteration = ?1 ORDER BY c.position DESC LIMIT ?2",
        iteration,
    )
    .await
}

/// The last fits of an iteration with their coefficients, as many as `text` holds the coefficients
/// of and at least one; and how many stand before them.
pub async fn last_with_coefficients(
    db: &mut SqliteConnection,
    iteration: i64,
    text: usize,
) -> Outcome<(Vec<TracedFit>, u64)> {
    // of a long answer only the coefficients leave the database
    let rows = sqlx::query_as::<_, Counted<TracedFitRow>>(concat!(
        "SELECT (SELECT count(*) FROM fits WHERE iteration = ?1) AS total, ",
        summary_columns!(),
        ", coefficients, prior, CASE WHEN coefficients IS NULL AND prior IS NULL THEN ",
        result_column!(),
        " END AS result FROM fits WHERE iteration = ?1 ORDER BY seq DESC LIMIT ?2"
    ))
    .bind(iteration)
    .bind(MAX_LISTED)
    .fetch(db);
    Ok(told(rows, text).await?)
}

impl Read<SqlitePool> for ListFits {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Page<FitSummary>> {
        let PageRequest { limit, after } = self.page;
        let (mut db, iteration) = within(from, caller, self.job, self.number).await?;
        let after = after.map_or(0, |cursor| locate::signed(cursor.number()));
        let rows: Vec<Listed<FitSummaryRow>> = sqlx::query_as(concat!(
            "SELECT seq AS place, ",
            summary_columns!(),
            " FROM fits WHERE iteration = ?1 AND seq > ?2 ORDER BY seq LIMIT ?3"
        ))
        .bind(iteration)
        .bind(after)
        .bind(i64::from(limit) + 1)
        .fetch_all(&mut *db)
        .await?;
        Ok(page(rows, limit))
    }
}

impl Read<SqlitePool> for GetFit {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<FitRecord> {
        let (mut db, iteration) = within(from, caller, self.job, self.number).await?;
        let row: Option<FitRow> = sqlx::query_as(concat!(
            "SELECT id, reason, actor, created_at, seq = ",
            chosen_fit!(),
            " AS chosen, flank_figures, spec, ",
            result_column!(),
            " AS result FROM fits WHERE iteration = ?1 AND id = ?2"
        ))
        .bind(iteration)
        .bind(self.fit)
        .fetch_optional(&mut *db)
        .await?;
        match row.ok_or(RepositoryError::NotFound(Resource::Fit))? {
            row if row.is_gone() => Err(gone::told(&mut db, self.job).await),
            row => Ok(row.into()),
        }
    }
}

/// Appends a fit to those of the iteration in row `iteration`; returns the fit's row.
pub async fn insert_row(db: &mut SqliteConnection, iteration: i64, fit: &NewFit) -> Outcome<i64> {
    let insert = concat!(
        "INSERT INTO fits (",
        fit_columns!(),
        ") VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"
    );
    Ok(bind(sqlx::query(insert), iteration, fit).execute(db).await?.last_insert_rowid())
}

/// Stores the choice of the fit in row `fit`.
pub async fn insert_choice(db: &mut SqliteConnection, iteration: i64, fit: i64, choice: &Choice) -> Outcome<()> {
    sqlx::query(
        "INSERT INTO fit_choices (iteration, position, fit, reason, actor, created_at)
         SELECT ?1, coalesce(max(position), 0) + 1, ?2, ?3, ?4, ?5 FROM fit_choices WHERE iteration = ?1",
    )
    .bind(iteration)
    .bind(fit)
    .bind(choice.event.reason.as_deref())
    .bind(choice.event.by.as_deref())
    .bind(time::to_text(choice.event.created_at))
    .execute(db)
    .await?;
    Ok(())
}

impl Write<SqliteConnection> for InsertFit {
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<Stored> {
        let (InsertFit { job, number, fit, receipt }, tenant) = (&asked.write, asked.tenant());
        let IterationVersion { seq, version } = locate::iteration(db, tenant, *job, *number).await?;
        answers::refuse_taken(db, tenant, receipt.as_ref()).await?;
        let mut chain = audit::of_job(db, asked.by(), *job).await?;
        let seq = insert_row(db, seq, fit).await?;
        asked.enter(&mut chain, Action::AddFit, target::fit(*job, *number, fit.id));
        audit::store(db, chain).await?;
        let stored = Stored { number: *number, version: version + 1 };
        let stored_fit = StoredFit { seq, result: &fit.computed.result };
        answers::keep(db, tenant, receipt.as_ref(), stored, fit.event.created_at, Some(stored_fit)).await?;
        Ok(stored)
    }
}

impl Write<SqliteConnection> for Choose {
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<Stored> {
        let (Choose { job, number, choice, precondition }, tenant) = (&asked.write, asked.tenant());
        let IterationVersion { seq, version } = locate::iteration(db, tenant, *job, *number).await?;
        precondition.check(version)?;
        let fit: i64 = sqlx::query_scalar("SELECT seq FROM fits WHERE iteration = ? AND id = ?")
            .bind(seq)
            .bind(choice.fit_id)
            .fetch_optional(&mut *db)
            .await?
            .ok_or(RepositoryError::ForeignFit(choice.fit_id))?;
        let latest: Option<Latest<i64>> = sqlx::query_as(
            "SELECT position, fit AS what, reason FROM fit_choices WHERE iteration = ? ORDER BY position DESC LIMIT 1",
        )
        .bind(seq)
        .fetch_optional(&mut *db)
        .await?;
        if latest.as_ref().is_some_and(|latest| latest.is(&fit, &choice.event)) {
            return Ok(Stored { number: *number, version });
        }
        let mut chain = audit::of_job(db, asked.by(), *job).await?;
        insert_choice(db, seq, fit, choice).await?;
        asked.enter(&mut chain, Action::ChooseFit, target::fit(*job, *number, choice.fit_id));
        audit::store(db, chain).await?;
        Ok(Stored { number: *number, version: version + 1 })
    }
}
