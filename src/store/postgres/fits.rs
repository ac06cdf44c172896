//! Fits of an iteration, and the chosen one.

use sqlx::{PgConnection, PgPool};
use uuid::Uuid;

use super::{
    document::encode,
    gone,
    keys::{FitPlace, StoredFit},
    locate::{self, signed, within},
    session::Session,
    time::stamp,
};
use crate::{
    jobs::{
        Caller, Choice, EncodedText, Figures, FitRecord, FitSummary, KeptBeside, MAX_LISTED, NewFit, Page, PageRequest,
        RepositoryError, Resource, Stored, TracedFit, audit::Action,
    },
    store::shared::{
        Asked, ChoiceRow, Choose, Counted, FitRow, FitSummaryRow, GetFit, InsertFit, Latest, ListFits, Listed, Outcome,
        Read, TracedFitRow, Write, figure_columns, page, target, told,
    },
};

/// The position of the fit that stands, of the iteration that is the statement's first two
/// parameters.
macro_rules! chosen_fit {
    () => {
        "(SELECT fit FROM fit_choices WHERE job = $1 AND number = $2 ORDER BY position DESC LIMIT 1)"
    };
}

/// The columns of a [`FitSummaryRow`].
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

/// How many fits the iteration has that is the statement's first two parameters.
macro_rules! total {
    () => {
        "(SELECT count(*) FROM fits WHERE job = $1 AND number = $2) AS total, "
    };
}

/// A fit about to be stored, with its place.
pub struct Placed<'a> {
    pub place: FitPlace,
    pub fit: &'a NewFit,
}

/// Stores fits, in the order given.
pub async fn insert_rows(db: &mut PgConnection, rows: &[Placed<'_>]) -> Outcome<()> {
    let beside = |of: fn(&KeptBeside) -> Option<&EncodedText>| {
        rows.iter().map(|row| of(row.fit.computed.result.kept_beside()).map(EncodedText::bytes)).collect::<Vec<_>>()
    };
    let place = |of: fn(&FitPlace) -> i64| rows.iter().map(|row| of(&row.place)).collect::<Vec<i64>>();
    let figure = |of: fn(&Figures) -> Option<f64>| {
        rows.iter().map(|row| of(&row.fit.computed.figures)).collect::<Vec<Option<f64>>>()
    };
    let name = |of: fn(&Figures) -> Option<&'static str>| {
        rows.iter().map(|row| of(&row.fit.computed.figures)).collect::<Vec<Option<&'static str>>>()
    };
    sqlx::query(concat!(
        "INSERT INTO fits (job, number, position, id, reason, actor, created_at, ",
        figure_columns!(),
        ", spec, result, flank_figures, coefficients, prior)
         SELECT * FROM unnest($1::uuid[], $2::bigint[], $3::bigint[], $4::uuid[], $5::text[], $6::text[],
                $7::timestamptz[], $8::float8[], $9::text[], $10::text[], $11::bigint[], $12::float8[], $13::float8[],
                $14::float8[], $15::float8[], $16::float8[], $17::float8[], $18::bytea[], $19::bytea[], $20::text[],
                $21::bytea[], $22::bytea[])"
    ))
    .bind(rows.iter().map(|row| row.place.job).collect::<Vec<Uuid>>())
    .bind(place(|place| place.number))
    .bind(place(|place| place.position))
    .bind(rows.iter().map(|row| row.fit.id).collect::<Vec<Uuid>>())
    .bind(rows.iter().map(|row| row.fit.event.reason.as_deref()).collect::<Vec<_>>())
    .bind(rows.iter().map(|row| row.fit.event.by.as_deref()).collect::<Vec<_>>())
    .bind(rows.iter().map(|row| stamp(row.fit.event.created_at)).collect::<Vec<_>>())
    .bind(figure(|figures| figures.lambda_star))
    .bind(name(|figures| figures.criterion))
    .bind(name(|figures| figures.scheme))
    .bind(rows.iter().map(|row| row.fit.computed.figures.count.map(i64::from)).collect::<Vec<_>>())
    .bind(figure(|figures| figures.condition))
    .bind(figure(|figures| figures.regularized_condition))
    .bind(figure(|figures| figures.bias_norm))
    .bind(figure(|figures| figures.bias_sharp_bound))
    .bind(figure(|figures| figures.rms))
    .bind(figure(|figures| figures.max_abs))
    .bind(rows.iter().map(|row| encode(&row.fit.computed.spec)).collect::<Vec<_>>())
    .bind(rows.iter().map(|row| row.fit.computed.result.bytes()).collect::<Vec<_>>())
    .bind(rows.iter().map(|row| row.fit.computed.flank.as_deref()).collect::<Vec<_>>())
    .bind(beside(|kept| kept.coefficients.as_ref()))
    .bind(beside(|kept| kept.prior.as_ref()))
    .execute(db)
    .await?;
    Ok(())
}

/// The last fits of an iteration, and how many stand before them.
pub async fn last(db: &mut PgConnection, job: Uuid, number: i64) -> Outcome<(Vec<FitSummary>, u64)> {
    locate::last::<FitSummaryRow, _>(
        db,
        concat!(
            "SELECT ",
            total!(),
            summary_columns!(),
            " FROM fits WHERE job = $1 AND number = $2 ORDER BY position DESC LIMIT $3"
        ),
        (job, number),
    )
    .await
}

/// The last choices of an iteration, and how many stand before them.
pub async fn last_choices(db: &mut PgConnection, job: Uuid, number: i64) -> Outcome<(Vec<Choice>, u64)> {
    locate::last::<ChoiceRow, _>(
        db,
        "SELECT (SELECT count(*) FROM fit_choices WHERE job = $1 AND number = $2) AS total,
                f.id AS fit_id, c.reason, c.actor, c.created_at
         FROM fit_choices c JOIN fits f ON f.job = c.job AND f.number = c.number AND f.position = c.fit
         WHERE c.job = $1 AND c.number = $2 ORDER BY c.position DESC LIMIT $3",
        (job, number),
    )
    .await
}

/// The last fits of an iteration with their coefficients, as many as `text` holds the coefficients
/// of and at least one; and how many stand before them.
pub async fn last_with_coefficients(
    db: &mut PgConnection,
    job: Uuid,
    number: i64,
    text: usize,
) -> Outcome<(Vec<TracedFit>, u64)> {
    // those kept beside their results are counted by their bytes here, perhaps compressed, and no
    // result up to 64 kB is, so what is sent is some times the room and a hundred of these at most;
    // what is told is counted by its text
    let rows = sqlx::query_as::<_, Counted<TracedFitRow>>(concat!(
        "SELECT * FROM (SELECT ",
        total!(),
        summary_columns!(),
        ", coefficients, prior, CASE WHEN coefficients IS NULL AND prior IS NULL THEN result END AS result,
           position, coalesce(sum(octet_length(coefficients)) OVER
               (ORDER BY position DESC ROWS BETWEEN UNBOUNDED PRECEDING AND 1 PRECEDING), 0) AS after
           FROM fits WHERE job = $1 AND number = $2 ORDER BY position DESC LIMIT $3) AS told
         WHERE after <= $4 ORDER BY position DESC"
    ))
    .bind(job)
    .bind(number)
    .bind(i64::from(MAX_LISTED))
    .bind(i64::try_from(text).unwrap_or(i64::MAX))
    .fetch(db);
    Ok(told(rows, text).await?)
}

impl Read<PgPool> for ListFits {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<Page<FitSummary>> {
        let PageRequest { limit, after } = self.page;
        let mut db = within(from, caller, self.job, self.number).await?;
        let rows: Vec<Listed<FitSummaryRow>> = sqlx::query_as(concat!(
            "SELECT position AS place, ",
            summary_columns!(),
            " FROM fits WHERE job = $1 AND number = $2 AND position > $3 ORDER BY position LIMIT $4"
        ))
        .bind(self.job)
        .bind(i64::from(self.number))
        .bind(after.map_or(0, |cursor| signed(cursor.number())))
        .bind(i64::from(limit) + 1)
        .fetch_all(&mut *db)
        .await?;
        Ok(page(rows, limit))
    }
}

impl Read<PgPool> for GetFit {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<FitRecord> {
        let mut db = within(from, caller, self.job, self.number).await?;
        let row: Option<FitRow> = sqlx::query_as(concat!(
            "SELECT id, reason, actor, created_at, position = ",
            chosen_fit!(),
            " AS chosen, flank_figures, spec, result FROM fits WHERE job = $1 AND number = $2 AND id = $3"
        ))
        .bind(self.job)
        .bind(i64::from(self.number))
        .bind(self.fit)
        .fetch_optional(&mut *db)
        .await?;
        match row.ok_or(RepositoryError::NotFound(Resource::Fit))? {
            row if row.is_gone() => Err(gone::told(&mut db, self.job).await),
            row => Ok(row.into()),
        }
    }
}

/// Appends a fit to those of an iteration; returns its place.
pub async fn insert_next(db: &mut PgConnection, job: Uuid, number: i64, fit: &NewFit) -> Outcome<FitPlace> {
    let last: i64 = sqlx::query_scalar("SELECT max(position) FROM fits WHERE job = $1 AND number = $2")
        .bind(job)
        .bind(number)
        .fetch_one(&mut *db)
        .await?;
    let place = FitPlace { job, number, position: last + 1 };
    insert_rows(db, &[Placed { place, fit }]).await?;
    Ok(place)
}

/// Stores the choice of a fit.
pub async fn insert_choice(db: &mut PgConnection, fit: FitPlace, choice: &Choice) -> Outcome<()> {
    sqlx::query(
        "INSERT INTO fit_choices (job, number, position, fit, reason, actor, created_at)
         SELECT $1, $2, coalesce(max(position), 0) + 1, $3, $4, $5, $6
         FROM fit_choices WHERE job = $1 AND number = $2",
    )
    .bind(fit.job)
    .bind(fit.number)
    .bind(fit.position)
    .bind(choice.event.reason.as_deref())
    .bind(choice.event.by.as_deref())
    .bind(stamp(choice.event.created_at))
    .execute(db)
    .await?;
    Ok(())
}

impl Write<Session> for InsertFit {
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<Stored> {
        let (InsertFit { job, number, fit, receipt }, tenant) = (&asked.write, asked.tenant());
        let version = locate::iteration(&mut session.db, tenant, *job, *number).await?;
        session.keys.refuse_taken(tenant, receipt.as_ref())?;
        session.enter(asked, *job, Action::AddFit, target::fit(*job, *number, fit.id)).await?;
        let place = insert_next(&mut session.db, *job, i64::from(*number), fit).await?;
        let stored = Stored { number: asked.write.number, version: version + 1 };
        let stored_fit = StoredFit { place, result: &fit.computed.result };
        session.keys.keep(tenant, receipt.as_ref(), stored, fit.event.created_at, Some(stored_fit));
        Ok(stored)
    }
}

impl Write<Session> for Choose {
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<Stored> {
        let (Choose { job, number, choice, precondition }, tenant) = (&asked.write, asked.tenant());
        let db = &mut session.db;
        let version = locate::iteration(db, tenant, *job, *number).await?;
        precondition.check(version)?;
        let fit: i64 = sqlx::query_scalar("SELECT position FROM fits WHERE job = $1 AND number = $2 AND id = $3")
            .bind(job)
            .bind(i64::from(*number))
            .bind(choice.fit_id)
            .fetch_optional(&mut *db)
            .await?
            .ok_or(RepositoryError::ForeignFit(choice.fit_id))?;
        let latest: Option<Latest<i64>> = sqlx::query_as(
            "SELECT position, fit AS what, reason FROM fit_choices WHERE job = $1 AND number = $2
             ORDER BY position DESC LIMIT 1",
        )
        .bind(job)
        .bind(i64::from(*number))
        .fetch_optional(&mut *db)
        .await?;
        if latest.as_ref().is_some_and(|latest| latest.is(&fit, &choice.event)) {
            return Ok(Stored { number: *number, version });
        }
        session.enter(asked, *job, Action::ChooseFit, target::fit(*job, *number, choice.fit_id)).await?;
        let place = FitPlace { job: *job, number: i64::from(*number), position: fit };
        insert_choice(&mut session.db, place, choice).await?;
        Ok(Stored { number: *number, version: version + 1 })
    }
}
