-- The schema. Keys begin with the job, then the number of the iteration, then the position of a thing within it, each 1, 2, 3 …
-- without gaps: the newest has the greatest position. A writer locks the row of the job first.
--
-- Documents (spec, request, result, …) are bytea: their text in UTF-8, or where it is longer than 8 kB a frame of zstd, whose first
-- bytes (28 B5 2F FD) no text begins with. They are returned byte for byte, so jsonb is not for them.

-- The last migration that a program must know to work on this schema. Later migrations only add, until one raises this.
CREATE TABLE schema_floor (
    one       boolean PRIMARY KEY DEFAULT true CHECK (one),
    migration bigint  NOT NULL
);
INSERT INTO schema_floor (migration) VALUES (1);

-- changed_at: when anything of the job was stored last. status: of the flank with the lowest rank. class: of the last evaluation.
-- folded: the text that is searched, made by the writer, since lower case depends on the locale. sort_name: its first line, as much
-- of it as an index takes. purged_at: the time of the purge once more, where every write looks.
CREATE TABLE jobs (
    id              uuid        PRIMARY KEY,
    tenant          text        NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    name            text        NOT NULL,
    part_number     text,
    serial_number   text,
    machine         text        COLLATE "C",
    gear            text,
    requirements    text,
    tags            text        NOT NULL,
    version         bigint      NOT NULL CHECK (version >= 1),
    created_at      timestamptz NOT NULL,
    updated_at      timestamptz NOT NULL,
    changed_at      timestamptz NOT NULL DEFAULT 'epoch',
    purged_at       timestamptz,
    iteration_count bigint      NOT NULL DEFAULT 0 CHECK (iteration_count >= 0),
    status          text        NOT NULL DEFAULT 'new' CHECK (status IN ('new', 'open', 'remachine', 'accepted', 'rejected')),
    class           bigint,
    folded          text        NOT NULL,
    sort_name       text        COLLATE "C" GENERATED ALWAYS AS (left(split_part(folded, E'\n', 1), 400)) STORED
);
CREATE INDEX jobs_of_tenant ON jobs (tenant, id);
CREATE INDEX jobs_by_change ON jobs (tenant, changed_at, id);
CREATE INDEX jobs_by_name ON jobs (tenant, sort_name, id);
CREATE INDEX jobs_by_status ON jobs (tenant, status, changed_at, id);
CREATE INDEX jobs_by_machine ON jobs (tenant, left(machine, 400), changed_at, id) WHERE machine IS NOT NULL;
CREATE INDEX jobs_by_part ON jobs (tenant, left(part_number, 400), changed_at, id) WHERE part_number IS NOT NULL;
CREATE INDEX jobs_by_class ON jobs (tenant, class, changed_at, id) WHERE class IS NOT NULL;

-- The texts once more, so that a change of a job that leaves its text as it is leaves this index alone.
CREATE TABLE job_texts (
    job    uuid PRIMARY KEY REFERENCES jobs ON DELETE CASCADE,
    tenant text NOT NULL,
    folded text NOT NULL
);

-- The parts of a text of one, two and three letters, and its tenant after four line ends, which is no part of a text. (pg_trgm would
-- need an extension, and knows letters and digits only.) The texts of a job have at most 21,000 letters.
CREATE FUNCTION text_parts(tenant text, searched text) RETURNS text[] LANGUAGE sql IMMUTABLE PARALLEL SAFE AS $$
    SELECT array_agg(part) || (E'\n\n\n\n' || tenant)
    FROM (
        SELECT DISTINCT unnest(ARRAY[letter, letter || next, letter || next || after]) COLLATE "C" AS part
        FROM (
            SELECT letter, lead(letter) OVER letters AS next, lead(letter, 2) OVER letters AS after
            FROM unnest(string_to_array(left(searched, 100000), NULL)) WITH ORDINALITY AS each (letter, place)
            WINDOW letters AS (ORDER BY place)
        ) AS three
    ) AS parts
    WHERE part IS NOT NULL
$$;

-- New rows wait in a list that each search reads, hence a short one.
CREATE INDEX job_texts_by_part ON job_texts USING gin (text_parts(tenant, folded)) WITH (gin_pending_list_limit = 256);

-- At most so many jobs whose text has all of these parts. The planner does not know how many there are, so it must use the index.
CREATE FUNCTION jobs_with_parts(parts text[], most bigint) RETURNS SETOF uuid LANGUAGE sql STABLE SET enable_seqscan = off
SET search_path FROM CURRENT AS $$
    SELECT job FROM job_texts WHERE text_parts(tenant, folded) @> parts LIMIT most
$$;

CREATE TABLE iterations (
    job         uuid        NOT NULL REFERENCES jobs (id),
    number      bigint      NOT NULL CHECK (number >= 1),
    id          uuid        NOT NULL,
    measured_at timestamptz,
    instrument  text,
    operator    text,
    note        text,
    flank       text        CHECK (flank IN ('left', 'right')),
    tooth       text,
    axes        text,
    created_at  timestamptz NOT NULL,
    PRIMARY KEY (job, number)
);

-- The nodes as posted, in a compact binary form whose first byte is its version.
CREATE TABLE nodes (
    job    uuid   NOT NULL,
    number bigint NOT NULL,
    count  bigint NOT NULL CHECK (count >= 0),
    data   bytea  NOT NULL,
    PRIMARY KEY (job, number),
    FOREIGN KEY (job, number) REFERENCES iterations (job, number)
);
ALTER TABLE nodes ALTER COLUMN data SET STORAGE EXTERNAL;

-- spec: the fit request without its nodes; result: the answer. coefficients and prior are those of a long result once more, so that
-- the trace, which shows them, reads no long results. flank_figures: slopes, crownings and twist by the job's gear and requirements of
-- that time, a JSON document. A figure that does not exist is NULL. actor: who did it, where one is known.
CREATE TABLE fits (
    job                   uuid        NOT NULL,
    number                bigint      NOT NULL,
    position              bigint      NOT NULL CHECK (position >= 1),
    id                    uuid        NOT NULL,
    reason                text,
    actor                 text,
    created_at            timestamptz NOT NULL,
    lambda_star           float8,
    criterion             text,
    scheme                text,
    count                 bigint,
    condition             float8,
    regularized_condition float8,
    bias_norm             float8,
    bias_sharp_bound      float8,
    rms                   float8,
    max_abs               float8,
    flank_figures         text,
    spec                  bytea       NOT NULL,
    coefficients          bytea,
    prior                 bytea,
    result                bytea       NOT NULL,
    PRIMARY KEY (job, number, position),
    UNIQUE (job, number, id),
    FOREIGN KEY (job, number) REFERENCES iterations (job, number)
);

-- The chosen fit is that of the choice with the greatest position. fit is the position of a fit of the same iteration.
CREATE TABLE fit_choices (
    job        uuid        NOT NULL,
    number     bigint      NOT NULL,
    position   bigint      NOT NULL CHECK (position >= 1),
    fit        bigint      NOT NULL,
    reason     text,
    actor      text,
    created_at timestamptz NOT NULL,
    PRIMARY KEY (job, number, position),
    FOREIGN KEY (job, number, fit) REFERENCES fits (job, number, position)
);

-- The decision with the greatest position holds. concession: an acceptance that needed a reason.
CREATE TABLE decisions (
    job        uuid        NOT NULL,
    number     bigint      NOT NULL,
    position   bigint      NOT NULL CHECK (position >= 1),
    decision   text        NOT NULL CHECK (decision IN ('accepted', 'remachine', 'rejected')),
    concession bigint      CHECK (concession = 1),
    reason     text,
    actor      text,
    created_at timestamptz NOT NULL,
    PRIMARY KEY (job, number, position),
    FOREIGN KEY (job, number) REFERENCES iterations (job, number)
);

-- Other results that are kept with an iteration. gear is that of the job when the record was made; class is the one that an evaluation
-- found. A record of the kind 'measurand' says what the nodes are of from then on: its column measurand is a JSON document with flank,
-- tooth, axes and accept_units; its method is 'posted' where it was stored with its iteration, else 'changed'.
CREATE TABLE records (
    job        uuid        NOT NULL,
    number     bigint      NOT NULL,
    position   bigint      NOT NULL CHECK (position >= 1),
    id         uuid        NOT NULL,
    kind       text        NOT NULL CHECK (kind IN ('measurand', 'curve', 'surface', 'deviations', 'evaluation', 'pitch', 'correction',
                                                    'gear_correction', 'applied')),
    method     text        NOT NULL,
    class      bigint      CHECK (class BETWEEN 1 AND 11),
    measurand  text        CHECK (measurand IS NULL OR measurand::json IS NOT NULL),
    actor      text,
    created_at timestamptz NOT NULL,
    gear       text,
    request    bytea       NOT NULL,
    result     bytea       NOT NULL,
    PRIMARY KEY (job, number, position),
    UNIQUE (job, number, id),
    FOREIGN KEY (job, number) REFERENCES iterations (job, number)
);
CREATE INDEX measurands ON records (job, number, position) WHERE kind = 'measurand';

-- Streams: nodes that arrive while the probe is still moving. iteration is set when the stream has become one. input_sha256 is a chain
-- over spec and blocks.
CREATE TABLE streams (
    id                uuid        PRIMARY KEY,
    job               uuid        NOT NULL REFERENCES jobs (id),
    forgetting_factor float8      NOT NULL CHECK (forgetting_factor > 0 AND forgetting_factor <= 1),
    sequence          bigint      NOT NULL CHECK (sequence >= 0),
    node_count        bigint      NOT NULL CHECK (node_count >= 0),
    input_sha256      bytea       NOT NULL CHECK (length(input_sha256) = 32),
    flank             text        CHECK (flank IN ('left', 'right')),
    tooth             text,
    axes              text,
    iteration         bigint,
    version           bigint      NOT NULL CHECK (version >= 1),
    created_at        timestamptz NOT NULL,
    updated_at        timestamptz NOT NULL,
    spec              bytea       NOT NULL,
    FOREIGN KEY (job, iteration) REFERENCES iterations (job, number)
);
CREATE INDEX streams_of_job ON streams (job);

-- Blocks of nodes as posted (the form of table nodes), until the stream is finished; then its iteration holds them.
CREATE TABLE stream_blocks (
    stream     uuid        NOT NULL REFERENCES streams (id),
    sequence   bigint      NOT NULL CHECK (sequence >= 1),
    sha256     bytea       NOT NULL CHECK (length(sha256) = 32),
    count      bigint      NOT NULL CHECK (count >= 1),
    created_at timestamptz NOT NULL,
    data       bytea       NOT NULL,
    PRIMARY KEY (stream, sequence)
);
ALTER TABLE stream_blocks ALTER COLUMN data SET STORAGE EXTERNAL;

-- The numbers of an estimate after a block, so that an open stream goes on without reading every node again.
CREATE TABLE stream_states (
    stream   uuid   PRIMARY KEY REFERENCES streams (id),
    sequence bigint NOT NULL CHECK (sequence >= 1),
    data     bytea  NOT NULL
);
ALTER TABLE stream_states ALTER COLUMN data SET STORAGE EXTERNAL;

-- What happened to a job, numbered 1, 2, 3 … within it. Triggers write the rows, in the transaction of the thing itself. They name what
-- happened (fit, position: within the iteration; stream, state, …: of a stream, which may be deleted later); the rest is read from the
-- thing.
CREATE TABLE events (
    job        uuid        NOT NULL REFERENCES jobs (id),
    number     bigint      NOT NULL CHECK (number >= 1),
    kind       text        NOT NULL CHECK (kind IN ('iteration', 'fit', 'decision', 'stream', 'purged', 'record', 'job')),
    iteration  bigint,
    fit        bigint,
    position   bigint,
    record     uuid,
    stream     uuid,
    state      text        CHECK (state IN ('open', 'block', 'finished', 'deleted')),
    sequence   bigint,
    node_count bigint,
    created_at timestamptz NOT NULL,
    PRIMARY KEY (job, number)
);

-- All that happens to the jobs of a tenant: events of jobs by their numbers, and jobs that were created or deleted, which are no events
-- of their own. Transactions do not end in the order in which they write; so the order is that of the transactions (changed_by) and
-- within one that of writing (place), and a reader looks no further than to the first transaction that has not ended.
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
-- small, because the numbers of transactions ascend with the rows
CREATE INDEX told_by_transaction ON told USING brin (changed_by);

-- How far the order of all jobs' events had come at a time: all transactions up to this one had ended. gone: the rows until then were
-- forgotten, or are about to be, and whoever asks for what came after an earlier place has missed something.
CREATE TABLE told_until (
    at         timestamptz PRIMARY KEY,
    changed_by bigint      NOT NULL,
    gone       boolean     NOT NULL DEFAULT false
);

-- The newest iteration of each flank and tooth of a job ('' where it was not given), and the rank of its decision: 1 rejected,
-- 2 remachine, 3 open, 4 accepted. Triggers keep these rows and the status of the job.
CREATE TABLE flanks (
    job    uuid   NOT NULL REFERENCES jobs (id),
    flank  text   NOT NULL CHECK (flank IN ('', 'left', 'right')),
    tooth  text   NOT NULL,
    number bigint NOT NULL,
    rank   bigint NOT NULL CHECK (rank BETWEEN 1 AND 4)
);
-- by digests, since an index takes no text of any length
CREATE UNIQUE INDEX flanks_by_tooth ON flanks (job, flank, md5(tooth));

-- Jobs whose nodes, results, texts and names were removed, with the reason. A row of the trace loses these only together with such a row;
-- it keeps its numbers and times.
CREATE TABLE purges (
    job    uuid        PRIMARY KEY REFERENCES jobs (id),
    at     timestamptz NOT NULL,
    reason text        NOT NULL
);

-- Answers kept for clients that ask again with the same Idempotency-Key; scope is method and path. A row without an answer is a claim:
-- it is given one, or deleted, before its transaction ends. Where an answer has the result of a fit in it, the fit is named, body is
-- the part before the result, and body_end the part after it. about: the job or stream, with which a purge removes the answer.
CREATE TABLE idempotency_keys (
    tenant         text        NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    key            text        NOT NULL,
    scope          text        NOT NULL,
    request_sha256 bytea       CHECK (length(request_sha256) = 32),
    status         bigint,
    location       text,
    etag           text,
    job            uuid,
    number         bigint,
    fit            bigint,
    created_at     timestamptz,
    body           bytea,
    body_end       bytea,
    about          uuid,
    PRIMARY KEY (tenant, key, scope),
    FOREIGN KEY (job, number, fit) REFERENCES fits (job, number, position),
    CHECK (num_nonnulls(request_sha256, status, body, created_at) IN (0, 4)),
    CHECK (num_nonnulls(job, number, fit, body_end) IN (0, 4))
);
CREATE INDEX idempotency_keys_by_age ON idempotency_keys (created_at);
CREATE INDEX idempotency_keys_about ON idempotency_keys (about) WHERE about IS NOT NULL;

-- Tenants, each a plant. id is a UUIDv7: the order of id is that of creation. Jobs name their tenant themselves.
CREATE TABLE tenants (
    name        text        PRIMARY KEY CHECK (length(name) BETWEEN 1 AND 63),
    id          uuid        NOT NULL UNIQUE,
    description text,
    suspended   boolean     NOT NULL,
    version     bigint      NOT NULL CHECK (version >= 1),
    created_at  timestamptz NOT NULL,
    updated_at  timestamptz NOT NULL
);
-- The tenant of callers without a tenant.
INSERT INTO tenants (name, id, suspended, version, created_at, updated_at)
VALUES ('default', '00000000-0000-0000-0000-000000000000', false, 1, '2026-11-23T00:00:00Z', '2026-11-23T00:00:00Z');

-- Keys: the digest of a secret, or the name of a certificate (san). id is 16 hexadecimal digits, compared byte by byte; scopes are names
-- with spaces between them. A key stays for good: its end is revoked_at or expires_at. The tenant of keys of no tenant is '@root'.
-- replaced_by: the key that took its place; such a key is not rotated once more, and its end is not put off.
CREATE TABLE api_keys (
    id           text        COLLATE "C" PRIMARY KEY CHECK (length(id) = 16),
    tenant       text        NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    name         text        NOT NULL,
    role         text        CHECK (role IN ('reader', 'operator', 'engineer', 'auditor', 'admin', 'root')),
    scopes       text        NOT NULL,
    sha256       bytea       CHECK (length(sha256) = 32),
    san          text,
    version      bigint      NOT NULL CHECK (version >= 1),
    created_at   timestamptz NOT NULL,
    expires_at   timestamptz,
    last_used_at timestamptz,
    revoked_at   timestamptz,
    replaced_by  text        COLLATE "C" REFERENCES api_keys (id),
    CHECK ((sha256 IS NULL) <> (san IS NULL))
);
CREATE INDEX api_keys_of_tenant ON api_keys (tenant, created_at, id);
CREATE INDEX api_keys_by_san ON api_keys (san) WHERE san IS NOT NULL;
-- One caller has a certificate.
CREATE UNIQUE INDEX api_keys_one_for_each_san ON api_keys (san) WHERE san IS NOT NULL AND revoked_at IS NULL;

-- Who changed what: one entry for each change, in the transaction of the change. contents: for each row that the change wrote, one byte
-- for the length of its name, the name, and its SHA-256. salt: random bytes that these begin with; who: the digest of salt and actor. A
-- purge removes actor and salt, so that nobody can try names against the digests that stay. A job may be deleted; its entries stay.
-- changed_by: the transaction, by whose number the sealer knows what is new.
CREATE TABLE audit (
    id         uuid        PRIMARY KEY,
    tenant     text        NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    job        uuid,
    at         timestamptz NOT NULL,
    actor      text,
    action     text        NOT NULL,
    subject    text        NOT NULL,
    request_id text,
    peer       text,
    contents   bytea       NOT NULL,
    salt       bytea       CHECK (length(salt) = 32),
    who        bytea       NOT NULL CHECK (length(who) = 32),
    changed_by bigint      NOT NULL DEFAULT (pg_current_xact_id()::text::bigint)
);
CREATE INDEX audit_of_tenant ON audit (tenant, id);
CREATE INDEX audit_of_job ON audit (job, id) WHERE job IS NOT NULL;
CREATE INDEX audit_by_transaction ON audit USING brin (changed_by);

-- The entries of a tenant in the order in which they were found committed; each place holds the digest of the one before it and of its
-- entry. Writers do not write here, so that they do not wait for each other.
CREATE TABLE audit_chain (
    tenant text   NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    number bigint NOT NULL CHECK (number >= 1),
    entry  uuid   NOT NULL UNIQUE REFERENCES audit (id),
    sha256 bytea  NOT NULL CHECK (length(sha256) = 32),
    PRIMARY KEY (tenant, number)
);

-- Seals: how far the chain of a tenant had come. upto: all transactions before this one had ended.
CREATE TABLE audit_seals (
    tenant      text        NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    number      bigint      NOT NULL CHECK (number >= 1),
    at          timestamptz NOT NULL,
    last_entry  bigint      NOT NULL CHECK (last_entry >= 1),
    last_sha256 bytea       NOT NULL CHECK (length(last_sha256) = 32),
    previous    bytea       NOT NULL CHECK (length(previous) = 32),
    sha256      bytea       NOT NULL CHECK (length(sha256) = 32),
    signature   bytea       CHECK (length(signature) = 64),
    public_key  bytea       CHECK (length(public_key) = 32),
    upto        bigint      NOT NULL,
    PRIMARY KEY (tenant, number)
);
-- The newest seal of any tenant says how far the audit is sealed.
CREATE INDEX audit_seals_by_time ON audit_seals (at);

-- The mappings by which tables became iterations, proposed for the next table of the same instrument and form. key: digest of both, so
-- that no name is stored. mapping: as it was sent, without the names of columns. The number of a tenant's is bounded; a new one replaces
-- the oldest.
CREATE TABLE table_mappings (
    tenant  text        NOT NULL,
    key     bytea       NOT NULL CHECK (length(key) = 32),
    mapping text        NOT NULL,
    kept_at timestamptz NOT NULL,
    PRIMARY KEY (tenant, key)
);

-- One row that is written to find out whether the database can be written to. It is as large as an iteration: a single page may fit where
-- nothing else does.
CREATE TABLE probe (
    id         bigint      PRIMARY KEY CHECK (id = 1),
    checked_at timestamptz NOT NULL,
    filler     bytea
);
ALTER TABLE probe ALTER COLUMN filler SET STORAGE EXTERNAL;

-- Views

-- Iterations with what their nodes are of now.
CREATE VIEW measured AS
SELECT i.job, i.number, i.id, i.measured_at, i.instrument, i.operator, i.note, i.created_at,
       coalesce(r.measurand ->> 'flank', i.flank) AS flank, coalesce(r.measurand ->> 'tooth', i.tooth) AS tooth,
       coalesce((r.measurand -> 'axes')::text, i.axes) AS axes,
       coalesce((r.measurand ->> 'accept_units')::boolean, false) AS accept_units
FROM iterations i
LEFT JOIN LATERAL (SELECT m.measurand::json AS measurand FROM records m
                   WHERE m.job = i.job AND m.number = i.number AND m.kind = 'measurand'
                   ORDER BY m.position DESC LIMIT 1) AS r ON true;

-- What the rows of flanks must be, by the iterations and decisions.
CREATE VIEW expected_flanks AS
SELECT f.job, f.flank, f.tooth, f.number, CASE (
    SELECT d.decision FROM decisions d WHERE d.job = f.job AND d.number = f.number ORDER BY d.position DESC LIMIT 1
) WHEN 'rejected' THEN 1 WHEN 'remachine' THEN 2 WHEN 'accepted' THEN 4 ELSE 3 END::bigint AS rank
FROM (SELECT m.job, coalesce(m.flank, '') AS flank, coalesce(m.tooth, '') AS tooth, max(m.number) AS number
      FROM measured m GROUP BY 1, 2, 3) AS f;

-- The first transaction that may not have ended; a later one may have written already. next: the next one to begin.
CREATE VIEW horizon AS
SELECT pg_snapshot_xmin(pg_current_snapshot())::text::bigint AS told, pg_snapshot_xmin(pg_current_snapshot())::text::bigint AS audit,
       pg_snapshot_xmax(pg_current_snapshot())::text::bigint AS next;

-- What must not be changed or deleted

CREATE FUNCTION refuse_change() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    RAISE EXCEPTION '% is append-only', TG_TABLE_NAME USING ERRCODE = 'restrict_violation';
END
$$;

-- Refuses to change a row, except to take away what the argument names, of a purged job. Images are compared, so that −0.0 is not 0.0.
CREATE FUNCTION refuse_all_but_purge() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    IF NEW *<> jsonb_populate_record(OLD, TG_ARGV[0]::jsonb) OR NOT EXISTS (SELECT FROM purges WHERE job = OLD.job) THEN
        RAISE EXCEPTION '% is append-only', TG_TABLE_NAME USING ERRCODE = 'restrict_violation';
    END IF;
    RETURN NEW;
END
$$;

CREATE TRIGGER iterations_append_only BEFORE DELETE OR TRUNCATE ON iterations FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER iterations_not_changed BEFORE UPDATE ON iterations FOR EACH ROW
EXECUTE FUNCTION refuse_all_but_purge('{"operator": null, "note": null}');
CREATE TRIGGER nodes_append_only BEFORE DELETE OR TRUNCATE ON nodes FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER nodes_not_changed BEFORE UPDATE ON nodes FOR EACH ROW EXECUTE FUNCTION refuse_all_but_purge('{"data": ""}');
CREATE TRIGGER fits_append_only BEFORE DELETE OR TRUNCATE ON fits FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER fits_not_changed BEFORE UPDATE ON fits FOR EACH ROW
EXECUTE FUNCTION refuse_all_but_purge(
    '{"reason": null, "actor": null, "flank_figures": null, "spec": "", "result": "", "coefficients": null, "prior": null}'
);
CREATE TRIGGER fit_choices_append_only BEFORE DELETE OR TRUNCATE ON fit_choices FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER fit_choices_not_changed BEFORE UPDATE ON fit_choices FOR EACH ROW
EXECUTE FUNCTION refuse_all_but_purge('{"reason": null, "actor": null}');
CREATE TRIGGER decisions_append_only BEFORE DELETE OR TRUNCATE ON decisions FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER decisions_not_changed BEFORE UPDATE ON decisions FOR EACH ROW
EXECUTE FUNCTION refuse_all_but_purge('{"reason": null, "actor": null}');
CREATE TRIGGER records_append_only BEFORE DELETE OR TRUNCATE ON records FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER records_not_changed BEFORE UPDATE ON records FOR EACH ROW
EXECUTE FUNCTION refuse_all_but_purge('{"request": "", "result": "", "gear": null, "actor": null}');
CREATE TRIGGER audit_append_only BEFORE DELETE OR TRUNCATE ON audit FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER audit_not_changed BEFORE UPDATE ON audit FOR EACH ROW EXECUTE FUNCTION refuse_all_but_purge('{"actor": null, "salt": null}');

CREATE TRIGGER events_not_changed BEFORE UPDATE OR TRUNCATE ON events FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER purges_append_only BEFORE UPDATE OR DELETE OR TRUNCATE ON purges FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER audit_seals_append_only BEFORE UPDATE OR DELETE OR TRUNCATE ON audit_seals
FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER audit_chain_append_only BEFORE UPDATE OR DELETE OR TRUNCATE ON audit_chain
FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();

-- Only a job that has nothing else takes its events along.
CREATE FUNCTION refuse_loss_of_events() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    IF EXISTS (SELECT FROM iterations WHERE job = OLD.job) OR EXISTS (SELECT FROM streams WHERE job = OLD.job) THEN
        RAISE EXCEPTION 'events is append-only' USING ERRCODE = 'restrict_violation';
    END IF;
    RETURN OLD;
END
$$;
CREATE TRIGGER events_not_lost BEFORE DELETE ON events FOR EACH ROW EXECUTE FUNCTION refuse_loss_of_events();

-- Refuses with the argument as the reason.
CREATE FUNCTION refuse() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    RAISE EXCEPTION '%', TG_ARGV[0] USING ERRCODE = 'restrict_violation';
END
$$;
CREATE TRIGGER jobs_keep_their_tenant BEFORE UPDATE OF tenant ON jobs FOR EACH ROW
WHEN (NEW.tenant IS DISTINCT FROM OLD.tenant) EXECUTE FUNCTION refuse('a job stays with its tenant');
CREATE TRIGGER api_keys_no_delete BEFORE DELETE OR TRUNCATE ON api_keys FOR EACH STATEMENT EXECUTE FUNCTION refuse('keys are kept');
CREATE TRIGGER api_keys_stay_revoked BEFORE UPDATE OF revoked_at ON api_keys FOR EACH ROW
WHEN (OLD.revoked_at IS NOT NULL AND NEW.revoked_at IS DISTINCT FROM OLD.revoked_at) EXECUTE FUNCTION refuse('a revoked key stays revoked');
CREATE TRIGGER api_keys_stay_what_they_are BEFORE UPDATE OF id, tenant, role, scopes, sha256, san, created_at ON api_keys
FOR EACH ROW EXECUTE FUNCTION refuse('a key stays what it is');
CREATE TRIGGER api_keys_stay_replaced BEFORE UPDATE OF replaced_by, expires_at ON api_keys FOR EACH ROW
WHEN (OLD.replaced_by IS NOT NULL
      AND (NEW.replaced_by IS DISTINCT FROM OLD.replaced_by OR NEW.expires_at IS NULL OR NEW.expires_at > OLD.expires_at))
EXECUTE FUNCTION refuse('a replaced key stays replaced, and its end is not put off');

-- Takes away what a purged job has of the trace: with the rights of the owner, so that the service needs none to change it.
CREATE FUNCTION take_away() RETURNS trigger LANGUAGE plpgsql SECURITY DEFINER SET search_path FROM CURRENT AS $$
BEGIN
    UPDATE jobs SET purged_at = NEW.at WHERE id = NEW.job;
    UPDATE iterations SET operator = NULL, note = NULL WHERE job = NEW.job;
    UPDATE nodes SET data = '' WHERE job = NEW.job;
    UPDATE fits SET reason = NULL, actor = NULL, flank_figures = NULL, spec = '', result = '', coefficients = NULL, prior = NULL
    WHERE job = NEW.job;
    UPDATE fit_choices SET reason = NULL, actor = NULL WHERE job = NEW.job;
    UPDATE decisions SET reason = NULL, actor = NULL WHERE job = NEW.job;
    UPDATE records SET request = '', result = '', gear = NULL, actor = NULL WHERE job = NEW.job;
    DELETE FROM stream_states WHERE stream IN (SELECT id FROM streams WHERE job = NEW.job);
    DELETE FROM stream_blocks WHERE stream IN (SELECT id FROM streams WHERE job = NEW.job);
    UPDATE streams SET spec = '' WHERE job = NEW.job;
    -- the entry of the purge itself comes later
    UPDATE audit SET actor = NULL, salt = NULL WHERE job = NEW.job;
    RETURN NULL;
END
$$;
CREATE TRIGGER purges_take_away AFTER INSERT ON purges FOR EACH ROW EXECUTE FUNCTION take_away();

-- What the list of jobs is filtered and sorted by

CREATE FUNCTION note_text() RETURNS trigger LANGUAGE plpgsql SECURITY DEFINER SET search_path FROM CURRENT AS $$
BEGIN
    INSERT INTO job_texts (job, tenant, folded) VALUES (NEW.id, NEW.tenant, NEW.folded)
    ON CONFLICT (job) DO UPDATE SET folded = excluded.folded;
    RETURN NULL;
END
$$;
CREATE TRIGGER text_of_new_jobs AFTER INSERT ON jobs FOR EACH ROW EXECUTE FUNCTION note_text();
CREATE TRIGGER text_of_jobs AFTER UPDATE OF folded ON jobs FOR EACH ROW WHEN (NEW.folded <> OLD.folded) EXECUTE FUNCTION note_text();

CREATE FUNCTION note_change_of_job() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    NEW.changed_at := greatest(NEW.changed_at, NEW.updated_at);
    RETURN NEW;
END
$$;
CREATE TRIGGER change_of_jobs BEFORE INSERT OR UPDATE OF updated_at ON jobs FOR EACH ROW EXECUTE FUNCTION note_change_of_job();

-- Whoever stores many iterations notes them in their jobs once, before they are there; only what was not noted so is noted here.
CREATE FUNCTION note_iteration() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    UPDATE jobs SET iteration_count = greatest(iteration_count, NEW.number), changed_at = greatest(changed_at, NEW.created_at)
    WHERE id = NEW.job AND (iteration_count < NEW.number OR changed_at < NEW.created_at);
    INSERT INTO flanks (job, flank, tooth, number, rank)
    VALUES (NEW.job, coalesce(NEW.flank, ''), coalesce(NEW.tooth, ''), NEW.number, 3)
    ON CONFLICT (job, flank, md5(tooth)) DO UPDATE SET number = excluded.number, rank = 3;
    RETURN NULL;
END
$$;
CREATE TRIGGER change_of_iterations AFTER INSERT ON iterations FOR EACH ROW EXECUTE FUNCTION note_iteration();

-- The first fit and the first choice are made with their iteration.
CREATE FUNCTION note_change() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    UPDATE jobs SET changed_at = NEW.created_at WHERE id = NEW.job AND changed_at < NEW.created_at;
    RETURN NULL;
END
$$;
CREATE TRIGGER change_of_fits AFTER INSERT ON fits FOR EACH ROW WHEN (NEW.position > 1) EXECUTE FUNCTION note_change();
CREATE TRIGGER change_of_choices AFTER INSERT ON fit_choices FOR EACH ROW WHEN (NEW.position > 1) EXECUTE FUNCTION note_change();
CREATE TRIGGER change_of_records AFTER INSERT ON records FOR EACH ROW EXECUTE FUNCTION note_change();

CREATE FUNCTION note_class() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    UPDATE jobs SET class = NEW.class WHERE id = NEW.job;
    RETURN NULL;
END
$$;
CREATE TRIGGER class_of_jobs AFTER INSERT ON records FOR EACH ROW WHEN (NEW.kind = 'evaluation') EXECUTE FUNCTION note_class();

CREATE FUNCTION note_decision() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    UPDATE jobs SET changed_at = NEW.created_at WHERE id = NEW.job AND changed_at < NEW.created_at;
    UPDATE flanks SET rank = CASE NEW.decision WHEN 'rejected' THEN 1 WHEN 'remachine' THEN 2 ELSE 4 END
    WHERE job = NEW.job AND number = NEW.number;
    RETURN NULL;
END
$$;
CREATE TRIGGER change_of_decisions AFTER INSERT ON decisions FOR EACH ROW EXECUTE FUNCTION note_decision();

CREATE FUNCTION note_status() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    UPDATE jobs SET status = CASE (SELECT min(rank) FROM flanks WHERE job = NEW.job)
        WHEN 1 THEN 'rejected' WHEN 2 THEN 'remachine' WHEN 3 THEN 'open' ELSE 'accepted' END
    WHERE id = NEW.job;
    RETURN NULL;
END
$$;
CREATE TRIGGER status_of_new_flanks AFTER INSERT ON flanks FOR EACH ROW EXECUTE FUNCTION note_status();
CREATE TRIGGER status_of_flanks AFTER UPDATE OF rank ON flanks FOR EACH ROW WHEN (NEW.rank <> OLD.rank)
EXECUTE FUNCTION note_status();

-- An iteration that turns out to be of another flank leaves its own to the one before it.
CREATE FUNCTION note_measurand() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    DELETE FROM flanks WHERE job = NEW.job;
    INSERT INTO flanks (job, flank, tooth, number, rank)
    SELECT job, flank, tooth, number, rank FROM expected_flanks WHERE job = NEW.job;
    RETURN NULL;
END
$$;
CREATE TRIGGER flanks_of_measurands AFTER INSERT ON records FOR EACH ROW
WHEN (NEW.kind = 'measurand' AND NEW.method = 'changed') EXECUTE FUNCTION note_measurand();

-- Events

-- The next event of a job. The row of the job is locked by whoever writes, so the next number is free.
CREATE FUNCTION add_event(
    of uuid, kind text, created_at timestamptz, iteration bigint, fit bigint DEFAULT NULL, place bigint DEFAULT NULL,
    record uuid DEFAULT NULL
) RETURNS void LANGUAGE sql AS $$
    INSERT INTO events (job, number, kind, created_at, iteration, fit, position, record)
    SELECT of, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = of), kind, created_at, iteration, fit, place, record
$$;

CREATE FUNCTION tell_iteration() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    PERFORM add_event(NEW.job, 'iteration', NEW.created_at, NEW.number);
    RETURN NULL;
END
$$;
CREATE TRIGGER events_of_iterations AFTER INSERT ON iterations FOR EACH ROW EXECUTE FUNCTION tell_iteration();

-- The first fit belongs to its iteration's event, and so does the first choice.
CREATE FUNCTION tell_fit() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    PERFORM add_event(NEW.job, 'fit', NEW.created_at, NEW.number, fit => NEW.position);
    RETURN NULL;
END
$$;
CREATE TRIGGER events_of_fits AFTER INSERT ON fits FOR EACH ROW WHEN (NEW.position > 1) EXECUTE FUNCTION tell_fit();

CREATE FUNCTION tell_choice() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    PERFORM add_event(NEW.job, 'fit', NEW.created_at, NEW.number, fit => NEW.fit, place => NEW.position);
    RETURN NULL;
END
$$;
CREATE TRIGGER events_of_choices AFTER INSERT ON fit_choices FOR EACH ROW WHEN (NEW.position > 1)
EXECUTE FUNCTION tell_choice();

CREATE FUNCTION tell_decision() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    PERFORM add_event(NEW.job, 'decision', NEW.created_at, NEW.number, place => NEW.position);
    RETURN NULL;
END
$$;
CREATE TRIGGER events_of_decisions AFTER INSERT ON decisions FOR EACH ROW EXECUTE FUNCTION tell_decision();

CREATE FUNCTION tell_record() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    PERFORM add_event(NEW.job, 'record', NEW.created_at, NEW.number, record => NEW.id);
    RETURN NULL;
END
$$;
CREATE TRIGGER events_of_records AFTER INSERT ON records FOR EACH ROW EXECUTE FUNCTION tell_record();

-- The argument is the state that is told.
CREATE FUNCTION tell_stream() RETURNS trigger LANGUAGE plpgsql AS $$
DECLARE told streams := CASE WHEN TG_OP = 'DELETE' THEN OLD ELSE NEW END;
BEGIN
    INSERT INTO events (job, number, kind, created_at, iteration, stream, state, sequence, node_count)
    SELECT told.job, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = told.job), 'stream', told.updated_at,
           told.iteration, told.id, TG_ARGV[0], told.sequence, told.node_count;
    RETURN NULL;
END
$$;
CREATE TRIGGER events_of_new_streams AFTER INSERT ON streams FOR EACH ROW EXECUTE FUNCTION tell_stream('open');
CREATE TRIGGER events_of_blocks AFTER UPDATE OF sequence ON streams FOR EACH ROW WHEN (NEW.sequence > OLD.sequence)
EXECUTE FUNCTION tell_stream('block');
CREATE TRIGGER events_of_finished_streams AFTER UPDATE OF iteration ON streams FOR EACH ROW
WHEN (OLD.iteration IS NULL AND NEW.iteration IS NOT NULL) EXECUTE FUNCTION tell_stream('finished');
-- Whoever deletes a stream first sets its updated_at.
CREATE TRIGGER events_of_deleted_streams AFTER DELETE ON streams FOR EACH ROW EXECUTE FUNCTION tell_stream('deleted');

CREATE FUNCTION tell_purge() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    PERFORM add_event(NEW.job, 'purged', NEW.at, NULL);
    RETURN NULL;
END
$$;
CREATE TRIGGER events_of_purges AFTER INSERT ON purges FOR EACH ROW EXECUTE FUNCTION tell_purge();

-- Whoever changes a job writes all of it; triggers and purges name none of these columns.
CREATE FUNCTION tell_changed_job() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    PERFORM add_event(NEW.id, 'job', NEW.updated_at, NULL);
    RETURN NULL;
END
$$;
CREATE TRIGGER events_of_changed_jobs AFTER UPDATE OF name ON jobs FOR EACH ROW EXECUTE FUNCTION tell_changed_job();

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
