-- The class that an evaluation found, given by the writer; jobs have that of the evaluation that was kept last.
ALTER TABLE records ADD COLUMN class INTEGER CHECK (class BETWEEN 1 AND 11);
ALTER TABLE jobs ADD COLUMN class INTEGER;

-- A purge left nothing of a result.
DROP TRIGGER records_no_update;
UPDATE records SET class = CASE WHEN json_valid(result) THEN result ->> '$.class' END WHERE kind = 'evaluation';
UPDATE jobs SET class = (
    SELECT r.class FROM iterations i JOIN records r ON r.iteration = i.seq
    WHERE i.job = jobs.seq AND r.kind = 'evaluation' ORDER BY r.seq DESC LIMIT 1
);

CREATE TRIGGER class_of_jobs AFTER INSERT ON records WHEN NEW.kind = 'evaluation'
BEGIN
    UPDATE jobs SET class = NEW.class WHERE seq = (SELECT job FROM iterations WHERE seq = NEW.iteration);
END;

-- A purge takes away who had a record made.
CREATE TRIGGER records_no_update BEFORE UPDATE ON records
WHEN NEW.request <> '' OR NEW.result <> '' OR NEW.gear NOTNULL OR NEW.actor NOTNULL
     OR (NEW.seq, NEW.id, NEW.iteration, NEW.kind, NEW.method, NEW.class, NEW.created_at)
     IS NOT (OLD.seq, OLD.id, OLD.iteration, OLD.kind, OLD.method, OLD.class, OLD.created_at)
     OR NOT EXISTS (SELECT 1 FROM iterations i JOIN purges p ON p.job = i.job WHERE i.seq = OLD.iteration)
BEGIN
    SELECT RAISE (ABORT, 'records is append-only');
END;
