-- What the nodes of an iteration are of can be added or changed later. A record of the kind 'measurand' says so; its column of that name
-- is a JSON document with flank, tooth, axes and accept_units as they are from then on. A purge leaves the column, as it leaves those of
-- the iteration. The method is 'posted' where the record was stored with its iteration, else 'changed'.
ALTER TABLE records DROP CONSTRAINT records_kind_check;
ALTER TABLE records ADD CONSTRAINT records_kind_check
    CHECK (kind IN ('measurand', 'curve', 'surface', 'deviations', 'evaluation', 'pitch', 'correction', 'gear_correction', 'applied')) NOT VALID;
ALTER TABLE records VALIDATE CONSTRAINT records_kind_check;
ALTER TABLE records ADD COLUMN measurand text CHECK (measurand IS NULL OR measurand::json IS NOT NULL);
CREATE INDEX measurands ON records (job, number, position) WHERE kind = 'measurand';

-- Iterations with what their nodes are of now.
CREATE VIEW measured AS
SELECT i.job, i.number, i.id, i.measured_at, i.instrument, i.operator, i.note, i.created_at,
       coalesce(r.measurand ->> 'flank', i.flank) AS flank, coalesce(r.measurand ->> 'tooth', i.tooth) AS tooth,
       coalesce((r.measurand -> 'axes')::text, i.axes) AS axes,
       coalesce((r.measurand ->> 'accept_units')::boolean, false) AS units_accepted
FROM iterations i
LEFT JOIN LATERAL (SELECT m.measurand::json AS measurand FROM records m
                   WHERE m.job = i.job AND m.number = i.number AND m.kind = 'measurand'
                   ORDER BY m.position DESC LIMIT 1) AS r ON true;

-- A decision to accept that needed a reason is a concession.
ALTER TABLE decisions ADD COLUMN concession bigint CHECK (concession = 1);

-- The newest iteration of each flank and tooth of a job ('' where it was not given), and the rank of its decision: 1 rejected,
-- 2 remachine, 3 open, 4 accepted. The status of the job is that of the least rank. Triggers keep both.
CREATE TABLE flanks (
    job    uuid   NOT NULL REFERENCES jobs (id),
    flank  text   NOT NULL CHECK (flank IN ('', 'left', 'right')),
    tooth  text   NOT NULL,
    number bigint NOT NULL,
    rank   bigint NOT NULL CHECK (rank BETWEEN 1 AND 4)
);
-- by digests, since an index takes no text of any length
CREATE UNIQUE INDEX flanks_by_tooth ON flanks (job, flank, md5(tooth));

CREATE FUNCTION rank_of(decision text) RETURNS bigint LANGUAGE sql IMMUTABLE AS $$
    SELECT CASE decision WHEN 'reject' THEN 1 WHEN 'remachine' THEN 2 WHEN 'accept' THEN 4 ELSE 3 END
$$;

CREATE FUNCTION status_of(rank bigint) RETURNS text LANGUAGE sql IMMUTABLE AS $$
    SELECT CASE rank WHEN 1 THEN 'rejected' WHEN 2 THEN 'remachine' WHEN 3 THEN 'open' WHEN 4 THEN 'accepted' ELSE 'new' END
$$;

CREATE FUNCTION flanks_of(of uuid) RETURNS TABLE (flank text, tooth text, number bigint, rank bigint) LANGUAGE sql STABLE AS $$
    SELECT f.flank, f.tooth, f.number,
           rank_of((SELECT d.decision FROM decisions d WHERE d.job = of AND d.number = f.number ORDER BY d.position DESC LIMIT 1))
    FROM (SELECT coalesce(m.flank, '') AS flank, coalesce(m.tooth, '') AS tooth, max(m.number) AS number
          FROM measured m WHERE m.job = of GROUP BY 1, 2) AS f
$$;

INSERT INTO flanks (job, flank, tooth, number, rank)
SELECT j.id, f.flank, f.tooth, f.number, f.rank FROM jobs j CROSS JOIN LATERAL flanks_of(j.id) AS f;

UPDATE jobs SET status = status_of((SELECT min(rank) FROM flanks WHERE job = jobs.id))
WHERE status <> status_of((SELECT min(rank) FROM flanks WHERE job = jobs.id));

CREATE FUNCTION note_status() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    UPDATE jobs SET status = status_of((SELECT min(rank) FROM flanks WHERE job = NEW.job)) WHERE id = NEW.job;
    RETURN NULL;
END
$$;
CREATE TRIGGER status_of_new_flanks AFTER INSERT ON flanks FOR EACH ROW EXECUTE FUNCTION note_status();
CREATE TRIGGER status_of_flanks AFTER UPDATE OF rank ON flanks FOR EACH ROW WHEN (NEW.rank <> OLD.rank)
EXECUTE FUNCTION note_status();

CREATE OR REPLACE FUNCTION note_iteration() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    UPDATE jobs SET iteration_count = greatest(iteration_count, NEW.number), changed_at = greatest(changed_at, NEW.created_at)
    WHERE id = NEW.job AND (iteration_count < NEW.number OR changed_at < NEW.created_at);
    INSERT INTO flanks (job, flank, tooth, number, rank)
    VALUES (NEW.job, coalesce(NEW.flank, ''), coalesce(NEW.tooth, ''), NEW.number, 3)
    ON CONFLICT (job, flank, md5(tooth)) DO UPDATE SET number = excluded.number, rank = 3;
    RETURN NULL;
END
$$;

CREATE OR REPLACE FUNCTION note_decision() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    UPDATE jobs SET changed_at = NEW.created_at WHERE id = NEW.job AND changed_at < NEW.created_at;
    UPDATE flanks SET rank = rank_of(NEW.decision) WHERE job = NEW.job AND number = NEW.number;
    RETURN NULL;
END
$$;
DROP FUNCTION status_of(text);

-- An iteration that turns out to be of another flank leaves its own to the one before it.
CREATE FUNCTION note_measurand() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    DELETE FROM flanks WHERE job = NEW.job;
    INSERT INTO flanks (job, flank, tooth, number, rank) SELECT NEW.job, f.* FROM flanks_of(NEW.job) AS f;
    RETURN NULL;
END
$$;
CREATE TRIGGER flanks_of_measurands AFTER INSERT ON records FOR EACH ROW
WHEN (NEW.kind = 'measurand' AND NEW.method = 'changed') EXECUTE FUNCTION note_measurand();
