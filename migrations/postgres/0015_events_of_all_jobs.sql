-- Events of a job tell of its records, and that its own data were changed. record: of a record, its id.
ALTER TABLE events DROP CONSTRAINT events_kind_check;
ALTER TABLE events ADD CONSTRAINT events_kind_check
    CHECK (kind IN ('iteration', 'fit', 'decision', 'stream', 'operation', 'purged', 'record', 'job')) NOT VALID;
ALTER TABLE events VALIDATE CONSTRAINT events_kind_check;
ALTER TABLE events ADD COLUMN record uuid;

CREATE FUNCTION tell_record() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    INSERT INTO events (job, number, kind, created_at, iteration, record)
    SELECT NEW.job, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = NEW.job), 'record', NEW.created_at, NEW.number, NEW.id;
    RETURN NULL;
END
$$;
CREATE TRIGGER events_of_records AFTER INSERT ON records FOR EACH ROW EXECUTE FUNCTION tell_record();

-- Whoever changes a job writes all of it; triggers and purges name none of these columns.
CREATE FUNCTION tell_changed_job() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    PERFORM add_event(NEW.id, 'job', NEW.updated_at, NULL);
    RETURN NULL;
END
$$;
CREATE TRIGGER events_of_changed_jobs AFTER UPDATE OF name ON jobs FOR EACH ROW EXECUTE FUNCTION tell_changed_job();

-- All that happens to the jobs of a tenant: events of jobs by their numbers, and jobs that were made or deleted, which are no events of
-- their own. What happened before there was this table is not in it. Transactions do not end in the order in which they write; so what is
-- told is in the order of the transactions (changed_by) and within one in that of writing (place), and whoever reads looks no further than
-- to the first transaction that has not ended.
CREATE TABLE told (
    tenant     text        NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    changed_by bigint      NOT NULL DEFAULT (pg_current_xact_id()::text::bigint),
    place      bigint      NOT NULL GENERATED ALWAYS AS IDENTITY,
    job        uuid        NOT NULL,
    number     bigint      CHECK (number >= 1),
    state      text        CHECK (state IN ('created', 'deleted')),
    created_at timestamptz,
    PRIMARY KEY (tenant, changed_by, place),
    CHECK ((number IS NULL) = (state IS NOT NULL) AND (number IS NULL) = (created_at IS NOT NULL))
);

CREATE FUNCTION tell_all() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    INSERT INTO told (tenant, job, number) SELECT tenant, id, NEW.number FROM jobs WHERE id = NEW.job;
    RETURN NULL;
END
$$;
CREATE TRIGGER events_of_all AFTER INSERT ON events FOR EACH ROW EXECUTE FUNCTION tell_all();

CREATE FUNCTION tell_new_job() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    INSERT INTO told (tenant, job, state, created_at) VALUES (NEW.tenant, NEW.id, 'created', NEW.created_at);
    RETURN NULL;
END
$$;
CREATE TRIGGER events_of_new_jobs AFTER INSERT ON jobs FOR EACH ROW EXECUTE FUNCTION tell_new_job();
