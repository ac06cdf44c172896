-- What the nodes of an iteration are of can be added or changed later. A record of the kind 'measurand' says so; its column of that name
-- is a JSON document with flank, tooth, axes and accept_units as they are from then on. A purge leaves the column, as it leaves those of
-- the iteration. The method is 'posted' where the record was stored with its iteration, else 'changed'.
PRAGMA writable_schema = ON;
UPDATE sqlite_schema SET sql = replace(sql, 'CHECK (kind IN (''curve''', 'CHECK (kind IN (''measurand'', ''curve''')
WHERE type = 'table' AND name = 'records';
PRAGMA writable_schema = RESET;
ALTER TABLE records ADD COLUMN measurand TEXT CHECK (measurand IS NULL OR json_valid(measurand));

DROP TRIGGER records_no_update;
CREATE TRIGGER records_no_update BEFORE UPDATE ON records
WHEN NEW.request <> '' OR NEW.result <> '' OR NEW.gear NOTNULL OR NEW.actor NOTNULL
     OR (NEW.seq, NEW.id, NEW.iteration, NEW.kind, NEW.method, NEW.class, NEW.measurand, NEW.created_at)
     IS NOT (OLD.seq, OLD.id, OLD.iteration, OLD.kind, OLD.method, OLD.class, OLD.measurand, OLD.created_at)
     OR NOT EXISTS (SELECT 1 FROM iterations i JOIN purges p ON p.job = i.job WHERE i.seq = OLD.iteration)
BEGIN
    SELECT RAISE (ABORT, 'records is append-only');
END;

CREATE INDEX measurands ON records (iteration) WHERE kind = 'measurand';

-- Iterations with what their nodes are of now.
CREATE VIEW measured AS
SELECT i.seq AS seq, i.id AS id, i.job AS job, i.number AS number, i.measured_at AS measured_at, i.instrument AS instrument,
       i.operator AS operator, i.note AS note, i.created_at AS created_at,
       coalesce(r.measurand ->> '$.flank', i.flank) AS flank, coalesce(r.measurand ->> '$.tooth', i.tooth) AS tooth,
       coalesce(r.measurand -> '$.axes', i.axes) AS axes, coalesce(r.measurand ->> '$.accept_units', 0) AS units_accepted
FROM iterations i
LEFT JOIN records r ON r.seq = (SELECT max(m.seq) FROM records m WHERE m.iteration = i.seq AND m.kind = 'measurand');

-- A decision to accept that needed a reason is a concession.
ALTER TABLE decisions ADD COLUMN concession INTEGER CHECK (concession = 1);

DROP TRIGGER decisions_no_update;
CREATE TRIGGER decisions_no_update BEFORE UPDATE ON decisions
WHEN NEW.reason NOTNULL OR NEW.actor NOTNULL
     OR (NEW.iteration, NEW.position, NEW.decision, NEW.concession, NEW.created_at)
     IS NOT (OLD.iteration, OLD.position, OLD.decision, OLD.concession, OLD.created_at)
     OR NOT EXISTS (SELECT 1 FROM iterations i JOIN purges p ON p.job = i.job WHERE i.seq = OLD.iteration)
BEGIN
    SELECT RAISE (ABORT, 'decisions is append-only');
END;

-- The newest iteration of each flank and tooth of a job ('' where it was not given), and the rank of its decision: 1 rejected,
-- 2 remachine, 3 open, 4 accepted. The status of the job is that of the least rank. Triggers keep both.
CREATE TABLE flanks (
    job    INTEGER NOT NULL REFERENCES jobs (seq),
    flank  TEXT    NOT NULL CHECK (flank IN ('', 'left', 'right')),
    tooth  TEXT    NOT NULL,
    number INTEGER NOT NULL,
    rank   INTEGER NOT NULL CHECK (rank BETWEEN 1 AND 4),
    PRIMARY KEY (job, flank, tooth)
) STRICT, WITHOUT ROWID;

INSERT INTO flanks (job, flank, tooth, number, rank)
SELECT m.job, coalesce(m.flank, ''), coalesce(m.tooth, ''), max(m.number), 3 FROM measured m GROUP BY 1, 2, 3;

UPDATE flanks SET rank = CASE (
    SELECT d.decision FROM iterations i JOIN decisions d ON d.iteration = i.seq
    WHERE i.job = flanks.job AND i.number = flanks.number ORDER BY d.position DESC LIMIT 1
) WHEN 'reject' THEN 1 WHEN 'remachine' THEN 2 WHEN 'accept' THEN 4 ELSE 3 END;

UPDATE jobs SET status = CASE (SELECT min(rank) FROM flanks WHERE job = jobs.seq)
    WHEN 1 THEN 'rejected' WHEN 2 THEN 'remachine' WHEN 3 THEN 'open' WHEN 4 THEN 'accepted' ELSE 'new' END;

CREATE TRIGGER status_of_new_flanks AFTER INSERT ON flanks
BEGIN
    UPDATE jobs SET status = CASE (SELECT min(rank) FROM flanks WHERE job = NEW.job)
        WHEN 1 THEN 'rejected' WHEN 2 THEN 'remachine' WHEN 3 THEN 'open' ELSE 'accepted' END
    WHERE seq = NEW.job;
END;

CREATE TRIGGER status_of_flanks AFTER UPDATE OF rank ON flanks WHEN NEW.rank <> OLD.rank
BEGIN
    UPDATE jobs SET status = CASE (SELECT min(rank) FROM flanks WHERE job = NEW.job)
        WHEN 1 THEN 'rejected' WHEN 2 THEN 'remachine' WHEN 3 THEN 'open' ELSE 'accepted' END
    WHERE seq = NEW.job;
END;

DROP TRIGGER change_of_iterations;
CREATE TRIGGER change_of_iterations AFTER INSERT ON iterations
WHEN EXISTS (SELECT 1 FROM jobs WHERE seq = NEW.job AND (iteration_count < NEW.number OR changed_at < NEW.created_at))
BEGIN
    UPDATE jobs SET iteration_count = max(iteration_count, NEW.number), changed_at = max(changed_at, NEW.created_at)
    WHERE seq = NEW.job;
END;

CREATE TRIGGER flanks_of_iterations AFTER INSERT ON iterations
BEGIN
    INSERT INTO flanks (job, flank, tooth, number, rank)
    VALUES (NEW.job, coalesce(NEW.flank, ''), coalesce(NEW.tooth, ''), NEW.number, 3)
    ON CONFLICT (job, flank, tooth) DO UPDATE SET number = excluded.number, rank = 3;
END;

DROP TRIGGER change_of_decisions;
CREATE TRIGGER change_of_decisions AFTER INSERT ON decisions
BEGIN
    UPDATE jobs SET changed_at = NEW.created_at
    WHERE seq = (SELECT job FROM iterations WHERE seq = NEW.iteration) AND changed_at < NEW.created_at;
    UPDATE flanks SET rank = CASE NEW.decision WHEN 'reject' THEN 1 WHEN 'remachine' THEN 2 ELSE 4 END
    WHERE (job, number) = (SELECT job, number FROM iterations WHERE seq = NEW.iteration);
END;

-- An iteration that turns out to be of another flank leaves its own to the one before it.
CREATE TRIGGER flanks_of_measurands AFTER INSERT ON records WHEN NEW.kind = 'measurand' AND NEW.method = 'changed'
BEGIN
    DELETE FROM flanks WHERE job = (SELECT job FROM iterations WHERE seq = NEW.iteration);
    INSERT INTO flanks (job, flank, tooth, number, rank)
    SELECT f.job, f.flank, f.tooth, f.number, CASE (
        SELECT d.decision FROM iterations i JOIN decisions d ON d.iteration = i.seq
        WHERE i.job = f.job AND i.number = f.number ORDER BY d.position DESC LIMIT 1
    ) WHEN 'reject' THEN 1 WHEN 'remachine' THEN 2 WHEN 'accept' THEN 4 ELSE 3 END
    FROM (SELECT m.job AS job, coalesce(m.flank, '') AS flank, coalesce(m.tooth, '') AS tooth, max(m.number) AS number
          FROM measured m WHERE m.job = (SELECT job FROM iterations WHERE seq = NEW.iteration) GROUP BY 1, 2, 3) AS f;
END;
