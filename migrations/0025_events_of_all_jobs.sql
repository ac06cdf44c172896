-- Events of a job tell of its records, and that its own data were changed. Rows and triggers stay as they are, so the text of the check
-- alone is changed, as 0019 does. record: of a record, its id.
PRAGMA writable_schema = ON;
UPDATE sqlite_schema
SET sql = replace(sql, 'OR kind = ''purged'')', 'OR kind = ''purged'' OR kind = ''record'' OR kind = ''job'')')
WHERE type = 'table' AND name = 'events';
PRAGMA writable_schema = RESET;

ALTER TABLE events ADD COLUMN record BLOB CHECK (length(record) = 16);

CREATE TRIGGER events_of_records AFTER INSERT ON records
BEGIN
    INSERT INTO events (job, number, kind, iteration, record, created_at)
    SELECT i.job, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = i.job), 'record', i.seq, NEW.id, NEW.created_at
    FROM iterations i WHERE i.seq = NEW.iteration;
END;

-- Whoever changes a job writes all of it; triggers and purges name none of these columns.
CREATE TRIGGER events_of_changed_jobs AFTER UPDATE OF name ON jobs
BEGIN
    INSERT INTO events (job, number, kind, created_at)
    VALUES (NEW.seq, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = NEW.seq), 'job', NEW.updated_at);
END;

-- All that happens to the jobs of a tenant, in the order in which it was stored: events of jobs by their numbers, and jobs that were made
-- or deleted, which are no events of their own. What happened before there was this table is not in it.
CREATE TABLE told (
    place      INTEGER PRIMARY KEY AUTOINCREMENT,
    tenant     TEXT    NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    job        BLOB    NOT NULL CHECK (length(job) = 16),
    number     INTEGER CHECK (number >= 1),
    state      TEXT    CHECK (state IN ('created', 'deleted')),
    created_at TEXT    CHECK (length(created_at) = 27),
    CHECK ((number IS NULL) = (state NOTNULL) AND (number IS NULL) = (created_at NOTNULL))
) STRICT;

CREATE INDEX told_of_tenant ON told (tenant, place);

CREATE TRIGGER events_of_all AFTER INSERT ON events
BEGIN
    INSERT INTO told (tenant, job, number) SELECT tenant, id, NEW.number FROM jobs WHERE seq = NEW.job;
END;

CREATE TRIGGER events_of_new_jobs AFTER INSERT ON jobs
BEGIN
    INSERT INTO told (tenant, job, state, created_at) VALUES (NEW.tenant, NEW.id, 'created', NEW.created_at);
END;
