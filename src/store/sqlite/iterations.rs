//! Iterations and their nodes, read.

use sqlx::SqlitePool;

use super::{
    decisions, fits, gone, jobs,
    locate::{self, WithSeq, signed, which_is_missing},
};
use crate::{
    jobs::{
        Caller, Iteration, ListedIteration, Measurand, Page, PageRequest, Predecessor, RepositoryError, Rounds,
        Successors,
    },
    store::shared::{
        CorrectionRow, GetIteration, GetMeasurand, GetNodes, GetNodesUpTo, GetPredecessors, GetRounds, GetSuccessors,
        IterationRow, ListIterations, Listed, ListedIterationRow, MeasurandRow, MeasuredRow, NodesRow, Outcome,
        PredecessorRow, Read, SuccessorRow, damaged, figure_columns, page, predecessors, rounds, successors,
    },
};
use flankfit_engine::estimation::Nodes;

impl Read<SqlitePool> for GetIteration {
    async fn read(&self, Caller { tenant, .. }: &Caller, from: &SqlitePool) -> Outcome<Iteration> {
        let GetIteration { job, number } = *self;
        let mut db = from.begin().await?;
        let WithSeq { seq, row }: WithSeq<IterationRow> = locate::row(
            &mut db,
            "SELECT i.seq AS seq, i.id AS id, i.flank AS flank, i.tooth AS tooth, i.axes AS axes,
                i.units_accepted AS units_accepted, i.measured_at AS measured_at,
                i.instrument AS instrument, i.operator AS operator, i.note AS note,
                i.created_at AS created_at,
                (SELECT count FROM nodes WHERE iteration = i.seq) AS node_count,
                (SELECT count(*) FROM fits WHERE iteration = i.seq)
                + (SELECT count(*) FROM fit_choices WHERE iteration = i.seq)
                + (SELECT count(*) FROM decisions WHERE iteration = i.seq)
                + (SELECT count(*) FROM records
                   WHERE iteration = i.seq AND kind = 'measurand' AND method = 'changed') - 1
                  + (j.purged_at NOTNULL) AS version,
                j.purged_at AS purged_at
         FROM jobs j JOIN measured i ON i.job = j.seq WHERE j.id = ? AND j.tenant = ? AND i.number = ?",
            (tenant, job, number),
        )
        .await?;
        let fits = fits::last(&mut db, seq).await?;
        let decision = decisions::latest(&mut db, seq).await?;
        Ok(row.with((job, number), fits, decision))
    }
}

impl Read<SqlitePool> for ListIterations {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Page<ListedIteration>> {
        let PageRequest { limit, after } = self.page;
        let mut db = from.begin().await?;
        let (job, _) = jobs::located(&mut db, &caller.tenant, self.job).await?;
        let rows: Vec<Listed<ListedIterationRow>> = sqlx::query_as(concat!(
            "WITH listed AS MATERIALIZED (
                 SELECT i.*,
                        (SELECT fit FROM fit_choices WHERE iteration = i.seq ORDER BY position DESC LIMIT 1) AS stands,
                        (SELECT max(position) FROM decisions WHERE iteration = i.seq) AS last
                 FROM measured i WHERE i.job = ? AND i.number > ? ORDER BY i.number LIMIT ?
             )
             SELECT l.number AS place, l.number AS number, l.id AS iteration_id, l.flank AS flank, l.tooth AS tooth,
                    l.axes AS axes, l.units_accepted AS units_accepted, l.measured_at AS measured_at,
                    l.instrument AS instrument, l.operator AS operator,
                    l.created_at AS stored_at, d.decision AS decision, d.actor AS decided_by,
                    f.id AS id, f.reason AS reason, f.actor AS actor, f.created_at AS created_at, TRUE AS chosen,
                    (SELECT actor FROM fit_choices WHERE iteration = l.seq ORDER BY position DESC LIMIT 1) AS chosen_by,
                    f.flank_figures AS flank_figures, ",
            figure_columns!(),
            " FROM listed l JOIN fits f ON f.seq = l.stands
                  LEFT JOIN decisions d ON d.iteration = l.seq AND d.position = l.last
             ORDER BY l.number"
        ))
        .bind(job)
        .bind(after.map_or(0, |cursor| signed(cursor.number())))
        .bind(i64::from(limit) + 1)
        .fetch_all(&mut *db)
        .await?;
        Ok(page(rows, limit))
    }
}

impl Read<SqlitePool> for GetNodes {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Nodes> {
        let all = GetNodesUpTo { job: self.job, number: self.number, most: usize::MAX }.read(caller, from).await?;
        all.map_err(|length| RepositoryError::Failed(damaged("nodes", &format!("{length} bytes are not read"))).into())
    }
}

impl Read<SqlitePool> for GetNodesUpTo {
    /// Longer ones are not read: SQLite knows their length without.
    async fn read(&self, Caller { tenant, .. }: &Caller, from: &SqlitePool) -> Outcome<Result<Nodes, usize>> {
        let GetNodesUpTo { job, number, most } = *self;
        let mut db = from.acquire().await?;
        let row: Option<NodesRow> = sqlx::query_as(
            "SELECT length(n.data) AS length, CASE WHEN length(n.data) BETWEEN 1 AND ?3 THEN n.data END AS data
         FROM jobs j JOIN iterations i ON i.job = j.seq JOIN nodes n ON n.iteration = i.seq
         WHERE j.id = ?1 AND i.number = ?2 AND j.tenant = ?4",
        )
        .bind(job)
        .bind(number)
        .bind(i64::try_from(most).unwrap_or(i64::MAX))
        .bind(tenant.as_str())
        .fetch_optional(&mut *db)
        .await?;
        match row {
            Some(row) if row.is_gone() => Err(gone::told(&mut db, job).await),
            Some(row) => Ok(row.into()),
            None => Err(which_is_missing(&mut db, tenant, job).await),
        }
    }
}

impl Read<SqlitePool> for GetMeasurand {
    async fn read(&self, Caller { tenant, .. }: &Caller, from: &SqlitePool) -> Outcome<Measurand> {
        let GetMeasurand { job, number } = *self;
        let mut db = from.acquire().await?;
        let row: MeasurandRow = locate::row(
            &mut db,
            "SELECT i.flank AS flank, i.tooth AS tooth, i.axes AS axes, i.units_accepted AS units_accepted
         FROM jobs j JOIN measured i ON i.job = j.seq WHERE j.id = ? AND j.tenant = ? AND i.number = ?",
            (tenant, job, number),
        )
        .await?;
        Ok(row.into())
    }
}

impl Read<SqlitePool> for GetSuccessors {
    /// The first iteration after one, and the first that is of the same flank and tooth.
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Successors> {
        let GetSuccessors { job, number } = *self;
        let mut db = from.acquire().await?;
        let rows = sqlx::query_as::<_, SuccessorRow>(
            "SELECT i.number AS number, i.flank AS flank, i.tooth AS tooth, NULL AS axes
         FROM jobs j JOIN measured i ON i.job = j.seq WHERE j.id = ? AND j.tenant = ? AND i.number >= ?
         ORDER BY i.number",
        )
        .bind(job)
        .bind(caller.tenant.as_str())
        .bind(number)
        .fetch(&mut *db);
        Ok(successors(rows, number).await?)
    }
}

impl Read<SqlitePool> for GetPredecessors {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Vec<Predecessor>> {
        let GetPredecessors { job, wanted } = self;
        let mut db = from.begin().await?;
        gone::refuse(&mut db, &caller.tenant, *job).await?;
        let rows = sqlx::query_as::<_, PredecessorRow>(
            "SELECT i.number AS number, i.flank AS flank, i.tooth AS tooth, i.axes AS axes,
                (SELECT f.id FROM fit_choices c JOIN fits f ON f.seq = c.fit WHERE c.iteration = i.seq
                 ORDER BY c.position DESC LIMIT 1) AS fit_id
         FROM jobs j JOIN measured i ON i.job = j.seq
         WHERE j.id = ? AND j.tenant = ? AND i.number >= ? AND i.number < ? ORDER BY i.number DESC",
        )
        .bind(*job)
        .bind(caller.tenant.as_str())
        .bind(wanted.from)
        .bind(wanted.before.map_or(i64::MAX, i64::from))
        .fetch(&mut *db);
        Ok(predecessors(rows, wanted).await?)
    }
}

impl Read<SqlitePool> for GetRounds {
    async fn read(&self, Caller { tenant, .. }: &Caller, from: &SqlitePool) -> Outcome<Rounds> {
        let mut db = from.begin().await?;
        gone::refuse(&mut db, tenant, self.job).await?;
        let iterations: Vec<MeasuredRow> = sqlx::query_as(
            "SELECT i.number AS number, i.flank AS flank, i.tooth AS tooth, NULL AS axes, i.created_at AS created_at
             FROM jobs j JOIN measured i ON i.job = j.seq WHERE j.id = ? AND j.tenant = ? ORDER BY i.number",
        )
        .bind(self.job)
        .bind(tenant.as_str())
        .fetch_all(&mut *db)
        .await?;
        let corrections: Vec<CorrectionRow> = sqlx::query_as(
            "SELECT i.number AS number, r.id AS id, r.kind AS kind, r.created_at AS created_at
             FROM jobs j JOIN iterations i ON i.job = j.seq JOIN records r ON r.iteration = i.seq
             WHERE j.id = ? AND j.tenant = ? AND r.kind IN ('correction', 'gear_correction') ORDER BY r.seq",
        )
        .bind(self.job)
        .bind(tenant.as_str())
        .fetch_all(&mut *db)
        .await?;
        Ok(rounds(iterations, corrections))
    }
}
