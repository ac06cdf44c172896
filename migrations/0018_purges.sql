-- Jobs whose nodes, results, texts and names were taken away, with why, and with the digest of the archive that has them. What the trace may
-- lose it loses only beside such a row, and only so: the row that stays has its numbers and its times.
CREATE TABLE purges (
    job            INTEGER PRIMARY KEY REFERENCES jobs (seq),
    at             TEXT    NOT NULL CHECK (length(at) = 27),
    reason         TEXT    NOT NULL,
    archive_sha256 BLOB    NOT NULL CHECK (length(archive_sha256) = 32)
) STRICT;

CREATE TRIGGER purges_no_update BEFORE UPDATE ON purges
BEGIN
    SELECT RAISE (ABORT, 'purges is append-only');
END;

CREATE TRIGGER purges_no_delete BEFORE DELETE ON purges
BEGIN
    SELECT RAISE (ABORT, 'purges is append-only');
END;

-- The time of the purge once more, where every write looks.
ALTER TABLE jobs ADD COLUMN purged_at TEXT CHECK (length(purged_at) = 27);

CREATE TRIGGER purges_of_jobs AFTER INSERT ON purges
BEGIN
    UPDATE jobs SET purged_at = NEW.at WHERE seq = NEW.job;
END;

-- What is due: jobs that nobody has touched for long.
CREATE INDEX jobs_to_purge ON jobs (changed_at) WHERE purged_at IS NULL;

DROP TRIGGER iterations_no_update;
CREATE TRIGGER iterations_no_update BEFORE UPDATE ON iterations
WHEN NEW.operator NOTNULL OR NEW.note NOTNULL OR NOT EXISTS (SELECT 1 FROM purges WHERE job = OLD.job)
     OR (NEW.seq, NEW.id, NEW.job, NEW.number, NEW.measured_at, NEW.instrument, NEW.created_at, NEW.flank, NEW.tooth, NEW.axes)
     IS NOT (OLD.seq, OLD.id, OLD.job, OLD.number, OLD.measured_at, OLD.instrument, OLD.created_at, OLD.flank, OLD.tooth, OLD.axes)
BEGIN
    SELECT RAISE (ABORT, 'iterations is append-only');
END;

DROP TRIGGER nodes_no_update;
CREATE TRIGGER nodes_no_update BEFORE UPDATE ON nodes
WHEN NEW.data <> x'' OR (NEW.iteration, NEW.count) IS NOT (OLD.iteration, OLD.count)
     OR NOT EXISTS (SELECT 1 FROM iterations i JOIN purges p ON p.job = i.job WHERE i.seq = OLD.iteration)
BEGIN
    SELECT RAISE (ABORT, 'nodes is append-only');
END;

DROP TRIGGER fits_no_update;
CREATE TRIGGER fits_no_update BEFORE UPDATE ON fits
WHEN NEW.reason NOTNULL OR NEW.spec <> '' OR NEW.result <> ''
     OR NOT EXISTS (SELECT 1 FROM iterations i JOIN purges p ON p.job = i.job WHERE i.seq = OLD.iteration)
     OR (NEW.seq, NEW.id, NEW.iteration, NEW.created_at, NEW.lambda_star, NEW.criterion, NEW.scheme, NEW.count, NEW.condition,
         NEW.regularized_condition, NEW.bias_norm, NEW.bias_sharp_bound, NEW.rms, NEW.max_abs)
     IS NOT (OLD.seq, OLD.id, OLD.iteration, OLD.created_at, OLD.lambda_star, OLD.criterion, OLD.scheme, OLD.count, OLD.condition,
         OLD.regularized_condition, OLD.bias_norm, OLD.bias_sharp_bound, OLD.rms, OLD.max_abs)
BEGIN
    SELECT RAISE (ABORT, 'fits is append-only');
END;

DROP TRIGGER fit_choices_no_update;
CREATE TRIGGER fit_choices_no_update BEFORE UPDATE ON fit_choices
WHEN NEW.reason NOTNULL
     OR (NEW.iteration, NEW.position, NEW.fit, NEW.created_at) IS NOT (OLD.iteration, OLD.position, OLD.fit, OLD.created_at)
     OR NOT EXISTS (SELECT 1 FROM iterations i JOIN purges p ON p.job = i.job WHERE i.seq = OLD.iteration)
BEGIN
    SELECT RAISE (ABORT, 'fit_choices is append-only');
END;

DROP TRIGGER decisions_no_update;
CREATE TRIGGER decisions_no_update BEFORE UPDATE ON decisions
WHEN NEW.reason NOTNULL
     OR (NEW.iteration, NEW.position, NEW.decision, NEW.created_at) IS NOT (OLD.iteration, OLD.position, OLD.decision, OLD.created_at)
     OR NOT EXISTS (SELECT 1 FROM iterations i JOIN purges p ON p.job = i.job WHERE i.seq = OLD.iteration)
BEGIN
    SELECT RAISE (ABORT, 'decisions is append-only');
END;

DROP TRIGGER records_no_update;
CREATE TRIGGER records_no_update BEFORE UPDATE ON records
WHEN NEW.request <> '' OR NEW.result <> '' OR NEW.gear NOTNULL
     OR (NEW.seq, NEW.id, NEW.iteration, NEW.kind, NEW.method, NEW.created_at)
     IS NOT (OLD.seq, OLD.id, OLD.iteration, OLD.kind, OLD.method, OLD.created_at)
     OR NOT EXISTS (SELECT 1 FROM iterations i JOIN purges p ON p.job = i.job WHERE i.seq = OLD.iteration)
BEGIN
    SELECT RAISE (ABORT, 'records is append-only');
END;

-- Of an entry the name of who made it goes; sha256 still tells it.
DROP TRIGGER audit_no_update;
CREATE TRIGGER audit_no_update BEFORE UPDATE ON audit
WHEN NEW.actor <> '' OR NOT EXISTS (SELECT 1 FROM jobs j JOIN purges p ON p.job = j.seq WHERE j.id = OLD.chain)
     OR (NEW.seq, NEW.tenant, NEW.chain, NEW.number, NEW.id, NEW.at, NEW.action, NEW.target, NEW.request_id, NEW.peer, NEW.contents,
         NEW.outcome, NEW.previous, NEW.sha256)
     IS NOT (OLD.seq, OLD.tenant, OLD.chain, OLD.number, OLD.id, OLD.at, OLD.action, OLD.target, OLD.request_id, OLD.peer, OLD.contents,
         OLD.outcome, OLD.previous, OLD.sha256)
BEGIN
    SELECT RAISE (ABORT, 'audit is append-only');
END;
