//! Iterations and their nodes, read.

use flankfit_engine::estimation::Nodes;
use futures_util::TryStreamExt as _;

use super::{
    decisions, fits, gone, jobs,
    lists::{Listed, page},
    locate::{self, iteration_version, which_is_missing},
    prelude::*,
};

from_row! {
    Measurand { flank, tooth, axes, accept_units }
    MeasurementDetails { measured_at, instrument, operator, note }
    ListedIteration {
        @measurand, @fit,
        id = "iteration_id", number, measured_at, instrument, operator, created_at = "stored_at", decision, decided_by,
    }
    Iteration {
        @measurand, @details, id, job_id, number, created_at, node_count, version, purged_at;
        fits, earlier_fits, decision
    }
    TracedIteration {
        @measurand, id, number, measured_at, instrument, operator, created_at;
        fits, choices, decisions, records, earlier
    }
    Predecessor { @measurand, number, fit_id }
    MeasuredIteration { @measurand, number, created_at }
    MadeCorrection { number, id, kind, created_at }
}

row! {
    struct SuccessorRow {
        @measurand: Measurand,
        number: u32,
    }
}

row! {
    /// Nodes, unless they are longer than the limit, with their length.
    struct NodesRow {
        length: usize,
        data: Option<Nodes>,
    }
}

impl NodesRow {
    /// Returns whether the nodes were purged: no encoding of any is empty.
    fn is_gone(&self) -> bool {
        self.length == 0
    }
}

impl From<NodesRow> for Result<Nodes, usize> {
    fn from(NodesRow { length, data }: NodesRow) -> Self {
        data.ok_or(length)
    }
}

pub async fn iteration(db: &mut Db, Caller { tenant, .. }: &Caller, job: &Uuid, number: &u32) -> Outcome<Iteration> {
    let (job, number) = (*job, *number);
    let sql = concat!(
        "SELECT i.id, i.job AS job_id, i.number, i.flank, i.tooth, i.axes, i.accept_units, i.measured_at,
                i.instrument, i.operator, i.note, i.created_at,
                (SELECT count FROM nodes WHERE job = i.job AND number = i.number) AS node_count, ",
        iteration_version!(),
        " + CASE WHEN j.purged_at IS NULL THEN 0 ELSE 1 END AS version, j.purged_at
         FROM jobs j JOIN measured i ON i.job = j.id WHERE j.id = $1 AND j.tenant = $2 AND i.number = $3"
    );
    let found: Iteration = locate::row(db, sql, (tenant, job, number)).await?;
    let (fits, earlier_fits) = fits::last(db, job, number).await?;
    let decision = decisions::latest(db, job, number).await?;
    Ok(Iteration { fits, earlier_fits, decision, ..found })
}

pub async fn iterations(
    db: &mut Db,
    caller: &Caller,
    job: &Uuid,
    PageRequest { limit, after }: &PageRequest,
) -> Outcome<Page<ListedIteration>> {
    jobs::located(db, &caller.tenant, *job).await?;
    let sql = concat!(
        "WITH listed AS MATERIALIZED (
             SELECT i.*, (SELECT max(position) FROM fit_choices WHERE job = i.job AND number = i.number) AS choice,
                    (SELECT max(position) FROM decisions WHERE job = i.job AND number = i.number) AS latest
             FROM measured i WHERE i.job = $1 AND i.number > $2 ORDER BY i.number LIMIT $3
         )
         SELECT i.number AS place, i.number, i.id AS iteration_id, i.flank, i.tooth, i.axes, i.accept_units,
                i.measured_at, i.instrument, i.operator, i.created_at AS stored_at,
                d.decision, d.actor AS decided_by,
                f.id, f.reason, f.actor, f.created_at, true AS chosen, c.actor AS chosen_by, f.flank_figures, ",
        figure_columns!(),
        " FROM listed i
              JOIN fit_choices c ON c.job = i.job AND c.number = i.number AND c.position = i.choice
              JOIN fits f ON f.job = i.job AND f.number = i.number AND f.position = c.fit
              LEFT JOIN decisions d ON d.job = i.job AND d.number = i.number AND d.position = i.latest
         ORDER BY i.number"
    );
    let after = after.map_or(0, |cursor| cursor.number());
    let rows: Vec<Listed<ListedIteration>> = db.all(sql, args![job, after, i64::from(*limit) + 1]).await?;
    Ok(page(rows, *limit))
}

pub async fn nodes(db: &mut Db, caller: &Caller, job: &Uuid, number: &u32) -> Outcome<Nodes> {
    let all = nodes_up_to(db, caller, job, number, &usize::MAX).await?;
    all.map_err(|length| RepositoryError::Failed(damaged("nodes", &format!("{length} bytes are not read"))).into())
}

/// Longer nodes are not read: the database knows their length without reading them.
pub async fn nodes_up_to(
    db: &mut Db,
    Caller { tenant, .. }: &Caller,
    job: &Uuid,
    number: &u32,
    most: &usize,
) -> Outcome<Result<Nodes, usize>> {
    let sql = "SELECT CAST(length(n.data) AS bigint) AS length,
                      CASE WHEN length(n.data) BETWEEN 1 AND $3 THEN n.data END AS data
               FROM jobs j JOIN nodes n ON n.job = j.id WHERE j.id = $1 AND n.number = $2 AND j.tenant = $4";
    let row: Option<NodesRow> = db.maybe(sql, args![job, *number, *most, tenant]).await?;
    match row {
        Some(row) if row.is_gone() => Err(gone::refusal(db, *job).await),
        Some(row) => Ok(row.into()),
        None => Err(which_is_missing(db, tenant, *job).await),
    }
}

pub async fn measurand(db: &mut Db, Caller { tenant, .. }: &Caller, job: &Uuid, number: &u32) -> Outcome<Measurand> {
    let sql = "SELECT i.flank, i.tooth, i.axes, i.accept_units
               FROM jobs j JOIN measured i ON i.job = j.id WHERE j.id = $1 AND j.tenant = $2 AND i.number = $3";
    locate::row(db, sql, (tenant, *job, *number)).await
}

/// Returns the first iteration after one, and the first after it that is of the same flank and
/// tooth. Names of teeth are compared here and not by the database; the rows are short.
pub async fn successors(db: &mut Db, caller: &Caller, job: &Uuid, number: &u32) -> Outcome<Successors> {
    let sql = "SELECT i.number, i.flank, i.tooth, CAST(NULL AS text) AS axes, i.accept_units
               FROM jobs j JOIN measured i ON i.job = j.id WHERE j.id = $1 AND j.tenant = $2 AND i.number >= $3
               ORDER BY i.number";
    let mut rows = db.each::<SuccessorRow>(sql, args![job, &caller.tenant, *number])?;
    let (mut found, mut own) = (Successors::default(), None);
    while let Some(SuccessorRow { number: at, measurand }) = rows.try_next().await? {
        match &own {
            None if at == *number => own = Some(measurand),
            None => break,
            Some(own) => {
                found.any = found.any.or(Some(at));
                if measurand.is_alike(own) {
                    found.alike = Some(at);
                    break;
                }
            }
        }
    }
    Ok(found)
}

pub async fn predecessors(
    db: &mut Db,
    caller: &Caller,
    job: &Uuid,
    wanted: &Predecessors,
) -> Outcome<Vec<Predecessor>> {
    gone::refuse(db, &caller.tenant, *job).await?;
    let sql = "SELECT i.number, i.flank, i.tooth, i.axes, i.accept_units,
                      (SELECT f.id FROM fit_choices c
                            JOIN fits f ON f.job = c.job AND f.number = c.number AND f.position = c.fit
                       WHERE c.job = i.job AND c.number = i.number ORDER BY c.position DESC LIMIT 1) AS fit_id
               FROM jobs j JOIN measured i ON i.job = j.id
               WHERE j.id = $1 AND j.tenant = $2 AND i.number >= $3 AND i.number < $4 ORDER BY i.number DESC";
    let before = wanted.before.map_or(i64::MAX, i64::from);
    let mut rows = db.each::<Predecessor>(sql, args![job, &caller.tenant, wanted.from, before])?;
    let mut found = Vec::new();
    while let Some(predecessor) = rows.try_next().await? {
        if predecessor.measurand.is_alike(&wanted.of) {
            found.push(predecessor);
            if found.len() == wanted.most {
                break;
            }
        }
    }
    found.reverse();
    Ok(found)
}

pub async fn rounds(db: &mut Db, Caller { tenant, .. }: &Caller, job: &Uuid) -> Outcome<Rounds> {
    gone::refuse(db, tenant, *job).await?;
    let sql = "SELECT i.number, i.flank, i.tooth, CAST(NULL AS text) AS axes, i.accept_units, i.created_at
               FROM jobs j JOIN measured i ON i.job = j.id WHERE j.id = $1 AND j.tenant = $2 ORDER BY i.number";
    let iterations = db.all(sql, args![job, tenant]).await?;
    let sql = "SELECT r.number, r.id, r.kind, r.created_at FROM jobs j JOIN records r ON r.job = j.id
               WHERE j.id = $1 AND j.tenant = $2 AND r.kind IN ('correction', 'gear_correction')
               ORDER BY r.created_at, r.number, r.position";
    Ok(Rounds { iterations, corrections: db.all(sql, args![job, tenant]).await? })
}
