//! Iterations and their nodes, read.

use sqlx::PgPool;

use super::{
    decisions, fits, gone, jobs,
    locate::{self, signed, version, which_is_missing},
    open::snapshot,
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

impl Read<PgPool> for GetIteration {
    async fn read(&self, Caller { tenant, .. }: &Caller, from: &PgPool) -> Outcome<Iteration> {
        let GetIteration { job, number } = *self;
        let mut db = snapshot(from).await?;
        let row: IterationRow = locate::row(
            &mut db,
            concat!(
                "SELECT i.id, i.flank, i.tooth, i.axes, i.units_accepted, i.measured_at, i.instrument, i.operator,
                        i.note, i.created_at,
                        (SELECT count FROM nodes WHERE job = i.job AND number = i.number) AS node_count, ",
                version!(),
                " + (j.purged_at IS NOT NULL)::int AS version, j.purged_at
                 FROM jobs j JOIN measured i ON i.job = j.id WHERE j.id = $1 AND j.tenant = $2 AND i.number = $3"
            ),
            (tenant, job, number),
        )
        .await?;
        let fits = fits::last(&mut db, job, i64::from(number)).await?;
        let decision = decisions::latest(&mut db, job, i64::from(number)).await?;
        Ok(row.with((job, number), fits, decision))
    }
}

impl Read<PgPool> for ListIterations {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<Page<ListedIteration>> {
        let PageRequest { limit, after } = self.page;
        let mut db = snapshot(from).await?;
        jobs::located(&mut db, &caller.tenant, self.job).await?;
        let rows: Vec<Listed<ListedIterationRow>> = sqlx::query_as(concat!(
            "SELECT i.number AS place, i.number, i.id AS iteration_id, i.flank, i.tooth, i.axes, i.units_accepted,
                    i.measured_at, i.instrument, i.operator, i.created_at AS stored_at,
                    d.decision, d.actor AS decided_by,
                    f.id, f.reason, f.actor, f.created_at, true AS chosen, c.actor AS chosen_by, f.flank_figures, ",
            figure_columns!(),
            " FROM measured i
                  CROSS JOIN LATERAL (SELECT fit, actor FROM fit_choices WHERE job = i.job AND number = i.number
                                      ORDER BY position DESC LIMIT 1) AS c
                  JOIN fits f ON f.job = i.job AND f.number = i.number AND f.position = c.fit
                  LEFT JOIN LATERAL (SELECT decision, actor FROM decisions WHERE job = i.job AND number = i.number
                                     ORDER BY position DESC LIMIT 1) AS d ON true
             WHERE i.job = $1 AND i.number > $2 ORDER BY i.number LIMIT $3"
        ))
        .bind(self.job)
        .bind(after.map_or(0, |cursor| signed(cursor.number())))
        .bind(i64::from(limit) + 1)
        .fetch_all(&mut *db)
        .await?;
        Ok(page(rows, limit))
    }
}

impl Read<PgPool> for GetNodes {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<Nodes> {
        let all = GetNodesUpTo { job: self.job, number: self.number, most: usize::MAX }.read(caller, from).await?;
        all.map_err(|length| RepositoryError::Failed(damaged("nodes", &format!("{length} bytes are not read"))).into())
    }
}

impl Read<PgPool> for GetNodesUpTo {
    /// Longer ones are not read: their length is known without.
    async fn read(&self, Caller { tenant, .. }: &Caller, from: &PgPool) -> Outcome<Result<Nodes, usize>> {
        let GetNodesUpTo { job, number, most } = *self;
        let mut db = snapshot(from).await?;
        let row: Option<NodesRow> = sqlx::query_as(
            "SELECT octet_length(n.data)::bigint AS length, CASE WHEN octet_length(n.data) BETWEEN 1 AND $3 THEN n.data END
                    AS data
             FROM jobs j JOIN nodes n ON n.job = j.id WHERE j.id = $1 AND n.number = $2 AND j.tenant = $4",
        )
        .bind(job)
        .bind(i64::from(number))
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

impl Read<PgPool> for GetMeasurand {
    async fn read(&self, Caller { tenant, .. }: &Caller, from: &PgPool) -> Outcome<Measurand> {
        let GetMeasurand { job, number } = *self;
        let mut db = snapshot(from).await?;
        let row: MeasurandRow = locate::row(
            &mut db,
            "SELECT i.flank, i.tooth, i.axes, i.units_accepted
             FROM jobs j JOIN measured i ON i.job = j.id WHERE j.id = $1 AND j.tenant = $2 AND i.number = $3",
            (tenant, job, number),
        )
        .await?;
        Ok(row.into())
    }
}

impl Read<PgPool> for GetSuccessors {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<Successors> {
        let GetSuccessors { job, number } = *self;
        let rows = sqlx::query_as::<_, SuccessorRow>(
            "SELECT i.number, i.flank, i.tooth, NULL::text AS axes
             FROM jobs j JOIN measured i ON i.job = j.id WHERE j.id = $1 AND j.tenant = $2 AND i.number >= $3
             ORDER BY i.number",
        )
        .bind(job)
        .bind(caller.tenant.as_str())
        .bind(i64::from(number))
        .fetch(from);
        Ok(successors(rows, number).await?)
    }
}

impl Read<PgPool> for GetPredecessors {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<Vec<Predecessor>> {
        let GetPredecessors { job, wanted } = self;
        let mut db = snapshot(from).await?;
        gone::refuse(&mut db, &caller.tenant, *job).await?;
        let rows = sqlx::query_as::<_, PredecessorRow>(
            "SELECT i.number, i.flank, i.tooth, i.axes,
                    (SELECT f.id FROM fit_choices c
                          JOIN fits f ON f.job = c.job AND f.number = c.number AND f.position = c.fit
                     WHERE c.job = i.job AND c.number = i.number ORDER BY c.position DESC LIMIT 1) AS fit_id
             FROM jobs j JOIN measured i ON i.job = j.id
             WHERE j.id = $1 AND j.tenant = $2 AND i.number >= $3 AND i.number < $4 ORDER BY i.number DESC",
        )
        .bind(*job)
        .bind(caller.tenant.as_str())
        .bind(i64::from(wanted.from))
        .bind(wanted.before.map_or(i64::MAX, i64::from))
        .fetch(&mut *db);
        Ok(predecessors(rows, wanted).await?)
    }
}

impl Read<PgPool> for GetRounds {
    async fn read(&self, Caller { tenant, .. }: &Caller, from: &PgPool) -> Outcome<Rounds> {
        let mut db = snapshot(from).await?;
        gone::refuse(&mut db, tenant, self.job).await?;
        let iterations: Vec<MeasuredRow> = sqlx::query_as(
            "SELECT i.number, i.flank, i.tooth, NULL::text AS axes, i.created_at
             FROM jobs j JOIN measured i ON i.job = j.id WHERE j.id = $1 AND j.tenant = $2 ORDER BY i.number",
        )
        .bind(self.job)
        .bind(tenant.as_str())
        .fetch_all(&mut *db)
        .await?;
        let corrections: Vec<CorrectionRow> = sqlx::query_as(
            "SELECT r.number, r.id, r.kind, r.created_at
             FROM jobs j JOIN records r ON r.job = j.id
             WHERE j.id = $1 AND j.tenant = $2 AND r.kind IN ('correction', 'gear_correction')
             ORDER BY r.created_at, r.number, r.position",
        )
        .bind(self.job)
        .bind(tenant.as_str())
        .fetch_all(&mut *db)
        .await?;
        Ok(rounds(iterations, corrections))
    }
}
