-- Requests that are answered later. headers and result_headers are JSON documents; body and result are frames of zstd. key: the client's
-- idempotency key, or one of the operation's own; key_scope: method and path. Of an operation that runs, lease names who does it and until
-- when; of one that waits, lease_until says before when nobody takes it. bytes: what it takes here. What an operation has stored is answered
-- from idempotency_keys, so result is NULL then; status is not.
CREATE TABLE operations (
    id             uuid        PRIMARY KEY,
    tenant         text        NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    actor          text        NOT NULL,
    request_id     text,
    peer           text,
    scope          text        NOT NULL,
    scopes         text        NOT NULL,
    request        text        NOT NULL,
    job            uuid,
    key            text        NOT NULL,
    key_scope      text        NOT NULL,
    request_sha256 bytea       NOT NULL CHECK (octet_length(request_sha256) = 32),
    headers        text        NOT NULL,
    body           bytea       NOT NULL,
    state          text        NOT NULL CHECK (state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')),
    attempts       bigint      NOT NULL CHECK (attempts >= 0),
    lease          uuid,
    lease_until    timestamptz,
    progress       float8      NOT NULL,
    told_at        timestamptz,
    status         bigint,
    result_headers text,
    result         bytea,
    bytes          bigint      NOT NULL,
    created_at     timestamptz NOT NULL,
    begun_at       timestamptz,
    ended_at       timestamptz,
    UNIQUE (tenant, key, key_scope)
);
CREATE INDEX operations_open ON operations (created_at, id) WHERE state IN ('queued', 'running');
CREATE INDEX operations_of_tenant ON operations (tenant, id);
CREATE INDEX operations_by_end ON operations (ended_at) WHERE ended_at IS NOT NULL;

-- Events of a job tell of its operations, too.
ALTER TABLE events DROP CONSTRAINT events_kind_check;
ALTER TABLE events ADD CONSTRAINT events_kind_check
    CHECK (kind IN ('iteration', 'fit', 'decision', 'stream', 'operation')) NOT VALID;
ALTER TABLE events VALIDATE CONSTRAINT events_kind_check;
ALTER TABLE events ADD COLUMN operation uuid;
ALTER TABLE events ADD COLUMN operation_state text CHECK (operation_state IN ('queued', 'succeeded', 'failed', 'cancelled'));

-- Whoever writes here has locked the row of the job, if it is there: it may be deleted before its operation has ended.
CREATE FUNCTION tell_operation() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    INSERT INTO events (job, number, kind, created_at, operation, operation_state)
    SELECT j.id, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = j.id), 'operation',
           coalesce(NEW.ended_at, NEW.created_at), NEW.id, NEW.state
    FROM jobs j WHERE j.id = NEW.job AND j.tenant = NEW.tenant;
    RETURN NULL;
END
$$;
CREATE TRIGGER events_of_new_operations AFTER INSERT ON operations FOR EACH ROW WHEN (NEW.job IS NOT NULL)
EXECUTE FUNCTION tell_operation();
CREATE TRIGGER events_of_ended_operations AFTER UPDATE OF state ON operations FOR EACH ROW
WHEN (NEW.job IS NOT NULL AND OLD.ended_at IS NULL AND NEW.ended_at IS NOT NULL) EXECUTE FUNCTION tell_operation();
