-- The schema of SQLite. Tables, columns and keys are those of migrations/postgres/0001_schema.sql, which describes them; this file
-- describes only what differs: texts of times are RFC 3339 in UTC with 27 characters, so that their order is that of the times; ids
-- are 16 bytes. A table is WITHOUT ROWID where its rows are short.

CREATE TABLE jobs (
    -- the number of its text in jobs_text, which VACUUM must not change
    doc             INTEGER PRIMARY KEY,
    id              BLOB    NOT NULL UNIQUE CHECK (length(id) = 16),
    tenant          TEXT    NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    name            TEXT    NOT NULL,
    part_number     TEXT,
    serial_number   TEXT,
    machine         TEXT,
    gear            TEXT,
    requirements    TEXT,
    tags            TEXT    NOT NULL,
    version         INTEGER NOT NULL CHECK (version >= 1),
    created_at      TEXT    NOT NULL CHECK (length(created_at) = 27),
    updated_at      TEXT    NOT NULL CHECK (length(updated_at) = 27),
    changed_at      TEXT    NOT NULL DEFAULT '1970-01-01T00:00:00.000000Z' CHECK (length(changed_at) = 27),
    purged_at       TEXT    CHECK (length(purged_at) = 27),
    iteration_count INTEGER NOT NULL DEFAULT 0 CHECK (iteration_count >= 0),
    status          TEXT    NOT NULL DEFAULT 'new' CHECK (status IN ('new', 'open', 'remachine', 'accepted', 'rejected')),
    class           INTEGER,
    folded          TEXT    NOT NULL,
    sort_name       TEXT    GENERATED ALWAYS AS (substr(folded, 1, instr(folded || char(10), char(10)) - 1)) VIRTUAL
) STRICT;
CREATE INDEX jobs_of_tenant ON jobs (tenant, id);
CREATE INDEX jobs_by_change ON jobs (tenant, changed_at, id);
CREATE INDEX jobs_by_name ON jobs (tenant, sort_name, id);
CREATE INDEX jobs_by_status ON jobs (tenant, status, changed_at, id);
CREATE INDEX jobs_by_machine ON jobs (tenant, machine, changed_at, id) WHERE machine NOTNULL;
CREATE INDEX jobs_by_part ON jobs (tenant, part_number, changed_at, id) WHERE part_number NOTNULL;
CREATE INDEX jobs_by_class ON jobs (tenant, class, changed_at, id) WHERE class NOTNULL;

-- Three letters at a time of jobs.folded, with a line end behind it, so that each letter of a text begins three. Without content: what
-- is found is compared with jobs.folded. Deleted entries leave nothing in the file.
CREATE VIRTUAL TABLE jobs_text USING fts5(
    folded, content = '', columnsize = 0, detail = 'none', tokenize = 'trigram case_sensitive 1'
);
INSERT INTO jobs_text (jobs_text, rank) VALUES ('secure-delete', 1);
CREATE VIRTUAL TABLE jobs_text_terms USING fts5vocab(jobs_text, 'instance');

CREATE TABLE iterations (
    job         BLOB    NOT NULL REFERENCES jobs (id),
    number      INTEGER NOT NULL CHECK (number >= 1),
    id          BLOB    NOT NULL CHECK (length(id) = 16),
    measured_at TEXT    CHECK (length(measured_at) = 27),
    instrument  TEXT,
    operator    TEXT,
    note        TEXT,
    flank       TEXT    CHECK (flank IN ('left', 'right')),
    tooth       TEXT,
    axes        TEXT,
    created_at  TEXT    NOT NULL CHECK (length(created_at) = 27),
    PRIMARY KEY (job, number)
) STRICT;

CREATE TABLE nodes (
    job    BLOB    NOT NULL,
    number INTEGER NOT NULL,
    count  INTEGER NOT NULL CHECK (count >= 0),
    data   BLOB    NOT NULL,
    PRIMARY KEY (job, number),
    FOREIGN KEY (job, number) REFERENCES iterations (job, number)
) STRICT;

CREATE TABLE fits (
    job                   BLOB    NOT NULL,
    number                INTEGER NOT NULL,
    position              INTEGER NOT NULL CHECK (position >= 1),
    id                    BLOB    NOT NULL CHECK (length(id) = 16),
    reason                TEXT,
    actor                 TEXT,
    created_at            TEXT    NOT NULL CHECK (length(created_at) = 27),
    lambda_star           REAL,
    criterion             TEXT,
    scheme                TEXT,
    count                 INTEGER,
    condition             REAL,
    regularized_condition REAL,
    bias_norm             REAL,
    bias_sharp_bound      REAL,
    rms                   REAL,
    max_abs               REAL,
    flank_figures         TEXT,
    spec                  BLOB    NOT NULL,
    coefficients          BLOB,
    prior                 BLOB,
    result                BLOB    NOT NULL,
    PRIMARY KEY (job, number, position),
    UNIQUE (job, number, id),
    FOREIGN KEY (job, number) REFERENCES iterations (job, number)
) STRICT;

CREATE TABLE fit_choices (
    job        BLOB    NOT NULL,
    number     INTEGER NOT NULL,
    position   INTEGER NOT NULL CHECK (position >= 1),
    fit        INTEGER NOT NULL,
    reason     TEXT,
    actor      TEXT,
    created_at TEXT    NOT NULL CHECK (length(created_at) = 27),
    PRIMARY KEY (job, number, position),
    FOREIGN KEY (job, number, fit) REFERENCES fits (job, number, position)
) STRICT;

CREATE TABLE decisions (
    job        BLOB    NOT NULL,
    number     INTEGER NOT NULL,
    position   INTEGER NOT NULL CHECK (position >= 1),
    decision   TEXT    NOT NULL CHECK (decision IN ('accepted', 'remachine', 'rejected')),
    concession INTEGER CHECK (concession = 1),
    reason     TEXT,
    actor      TEXT,
    created_at TEXT    NOT NULL CHECK (length(created_at) = 27),
    PRIMARY KEY (job, number, position),
    FOREIGN KEY (job, number) REFERENCES iterations (job, number)
) STRICT;

CREATE TABLE records (
    job        BLOB    NOT NULL,
    number     INTEGER NOT NULL,
    position   INTEGER NOT NULL CHECK (position >= 1),
    id         BLOB    NOT NULL CHECK (length(id) = 16),
    kind       TEXT    NOT NULL CHECK (kind IN ('measurand', 'curve', 'surface', 'deviations', 'evaluation', 'pitch', 'correction',
                                                'gear_correction', 'applied')),
    method     TEXT    NOT NULL,
    class      INTEGER CHECK (class BETWEEN 1 AND 11),
    measurand  TEXT    CHECK (measurand IS NULL OR json_valid(measurand)),
    actor      TEXT,
    created_at TEXT    NOT NULL CHECK (length(created_at) = 27),
    gear       TEXT,
    request    BLOB    NOT NULL,
    result     BLOB    NOT NULL,
    PRIMARY KEY (job, number, position),
    UNIQUE (job, number, id),
    FOREIGN KEY (job, number) REFERENCES iterations (job, number)
) STRICT;
CREATE INDEX measurands ON records (job, number, position) WHERE kind = 'measurand';

CREATE TABLE streams (
    id                BLOB    NOT NULL PRIMARY KEY CHECK (length(id) = 16),
    job               BLOB    NOT NULL REFERENCES jobs (id),
    forgetting_factor REAL    NOT NULL CHECK (forgetting_factor > 0 AND forgetting_factor <= 1),
    sequence          INTEGER NOT NULL CHECK (sequence >= 0),
    node_count        INTEGER NOT NULL CHECK (node_count >= 0),
    input_sha256      BLOB    NOT NULL CHECK (length(input_sha256) = 32),
    flank             TEXT    CHECK (flank IN ('left', 'right')),
    tooth             TEXT,
    axes              TEXT,
    iteration         INTEGER,
    version           INTEGER NOT NULL CHECK (version >= 1),
    created_at        TEXT    NOT NULL CHECK (length(created_at) = 27),
    updated_at        TEXT    NOT NULL CHECK (length(updated_at) = 27),
    spec              BLOB    NOT NULL,
    FOREIGN KEY (job, iteration) REFERENCES iterations (job, number)
) STRICT;
CREATE INDEX streams_of_job ON streams (job);

CREATE TABLE stream_blocks (
    stream     BLOB    NOT NULL REFERENCES streams (id),
    sequence   INTEGER NOT NULL CHECK (sequence >= 1),
    sha256     BLOB    NOT NULL CHECK (length(sha256) = 32),
    count      INTEGER NOT NULL CHECK (count >= 1),
    created_at TEXT    NOT NULL CHECK (length(created_at) = 27),
    data       BLOB    NOT NULL,
    PRIMARY KEY (stream, sequence)
) STRICT;

CREATE TABLE stream_states (
    stream   BLOB    NOT NULL PRIMARY KEY REFERENCES streams (id),
    sequence INTEGER NOT NULL CHECK (sequence >= 1),
    data     BLOB    NOT NULL
) STRICT;

-- Three names and more after IN are looked up in a table that is made anew for each row that a trigger writes, which takes longer than
-- all other rows of an iteration; the same with OR is compared.
CREATE TABLE events (
    job        BLOB    NOT NULL REFERENCES jobs (id),
    number     INTEGER NOT NULL CHECK (number >= 1),
    kind       TEXT    NOT NULL CHECK (kind = 'iteration' OR kind = 'fit' OR kind = 'decision' OR kind = 'stream'
                                       OR kind = 'purged' OR kind = 'record' OR kind = 'job'),
    iteration  INTEGER,
    fit        INTEGER,
    position   INTEGER,
    record     BLOB    CHECK (length(record) = 16),
    stream     BLOB    CHECK (length(stream) = 16),
    state      TEXT    CHECK (state = 'open' OR state = 'block' OR state = 'finished' OR state = 'deleted'),
    sequence   INTEGER,
    node_count INTEGER,
    created_at TEXT    NOT NULL CHECK (length(created_at) = 27),
    PRIMARY KEY (job, number)
) STRICT, WITHOUT ROWID;

-- There is one writer, so changes are numbered in the order in which they end.
CREATE TABLE told (
    changed_by INTEGER PRIMARY KEY AUTOINCREMENT,
    place      INTEGER NOT NULL DEFAULT 0,
    tenant     TEXT    NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    job        BLOB    NOT NULL CHECK (length(job) = 16),
    number     INTEGER CHECK (number >= 1),
    state      TEXT    CHECK (state IN ('created', 'deleted')),
    created_at TEXT    CHECK (length(created_at) = 27),
    CHECK ((number IS NULL) = (state NOTNULL) AND (number IS NULL) = (created_at NOTNULL))
) STRICT;
CREATE INDEX told_of_tenant ON told (tenant, changed_by, place);

CREATE TABLE told_until (
    at         TEXT    NOT NULL PRIMARY KEY CHECK (length(at) = 27),
    changed_by INTEGER NOT NULL,
    gone       INTEGER NOT NULL DEFAULT 0 CHECK (gone IN (0, 1))
) STRICT, WITHOUT ROWID;

CREATE TABLE flanks (
    job    BLOB    NOT NULL REFERENCES jobs (id),
    flank  TEXT    NOT NULL CHECK (flank IN ('', 'left', 'right')),
    tooth  TEXT    NOT NULL,
    number INTEGER NOT NULL,
    rank   INTEGER NOT NULL CHECK (rank BETWEEN 1 AND 4),
    PRIMARY KEY (job, flank, tooth)
) STRICT, WITHOUT ROWID;

CREATE TABLE purges (
    job    BLOB NOT NULL PRIMARY KEY REFERENCES jobs (id),
    at     TEXT NOT NULL CHECK (length(at) = 27),
    reason TEXT NOT NULL
) STRICT;

CREATE TABLE idempotency_keys (
    tenant         TEXT    NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    key            TEXT    NOT NULL,
    scope          TEXT    NOT NULL,
    request_sha256 BLOB    CHECK (length(request_sha256) = 32),
    status         INTEGER,
    location       TEXT,
    etag           TEXT,
    job            BLOB,
    number         INTEGER,
    fit            INTEGER,
    created_at     TEXT    CHECK (length(created_at) = 27),
    body           BLOB,
    body_end       BLOB,
    about          BLOB,
    PRIMARY KEY (tenant, key, scope),
    FOREIGN KEY (job, number, fit) REFERENCES fits (job, number, position),
    CHECK ((request_sha256 IS NULL) + (status IS NULL) + (body IS NULL) + (created_at IS NULL) IN (0, 4)),
    CHECK ((job IS NULL) + (number IS NULL) + (fit IS NULL) + (body_end IS NULL) IN (0, 4))
) STRICT;
CREATE INDEX idempotency_keys_by_age ON idempotency_keys (created_at);
CREATE INDEX idempotency_keys_about ON idempotency_keys (about) WHERE about NOTNULL;

CREATE TABLE tenants (
    name        TEXT    NOT NULL PRIMARY KEY CHECK (length(name) BETWEEN 1 AND 63),
    id          BLOB    NOT NULL UNIQUE CHECK (length(id) = 16),
    description TEXT,
    suspended   INTEGER NOT NULL CHECK (suspended IN (0, 1)),
    version     INTEGER NOT NULL CHECK (version >= 1),
    created_at  TEXT    NOT NULL CHECK (length(created_at) = 27),
    updated_at  TEXT    NOT NULL CHECK (length(updated_at) = 27)
) STRICT;
INSERT INTO tenants (name, id, suspended, version, created_at, updated_at)
VALUES ('default', zeroblob(16), 0, 1, '2026-11-23T00:00:00.000000Z', '2026-11-23T00:00:00.000000Z');

CREATE TABLE api_keys (
    id           TEXT    NOT NULL PRIMARY KEY CHECK (length(id) = 16),
    tenant       TEXT    NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    name         TEXT    NOT NULL,
    role         TEXT    CHECK (role IN ('reader', 'operator', 'engineer', 'auditor', 'admin', 'root')),
    scopes       TEXT    NOT NULL,
    sha256       BLOB    CHECK (length(sha256) = 32),
    san          TEXT,
    version      INTEGER NOT NULL CHECK (version >= 1),
    created_at   TEXT    NOT NULL CHECK (length(created_at) = 27),
    expires_at   TEXT    CHECK (length(expires_at) = 27),
    last_used_at TEXT    CHECK (length(last_used_at) = 27),
    revoked_at   TEXT    CHECK (length(revoked_at) = 27),
    replaced_by  TEXT    REFERENCES api_keys (id),
    CHECK ((sha256 IS NULL) <> (san IS NULL))
) STRICT;
CREATE INDEX api_keys_of_tenant ON api_keys (tenant, created_at, id);
CREATE INDEX api_keys_by_san ON api_keys (san) WHERE san IS NOT NULL;
CREATE UNIQUE INDEX api_keys_one_for_each_san ON api_keys (san) WHERE san IS NOT NULL AND revoked_at IS NULL;

CREATE TABLE audit (
    changed_by INTEGER PRIMARY KEY,
    id         BLOB    NOT NULL UNIQUE CHECK (length(id) = 16),
    tenant     TEXT    NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    job        BLOB    CHECK (length(job) = 16),
    at         TEXT    NOT NULL CHECK (length(at) = 27),
    actor      TEXT,
    action     TEXT    NOT NULL,
    subject    TEXT    NOT NULL,
    request_id TEXT,
    peer       TEXT,
    contents   BLOB    NOT NULL,
    salt       BLOB    CHECK (length(salt) = 32),
    who        BLOB    NOT NULL CHECK (length(who) = 32)
) STRICT;
CREATE INDEX audit_of_tenant ON audit (tenant, id);
CREATE INDEX audit_of_job ON audit (job, id) WHERE job NOTNULL;

CREATE TABLE audit_chain (
    tenant TEXT    NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    number INTEGER NOT NULL CHECK (number >= 1),
    entry  BLOB    NOT NULL UNIQUE REFERENCES audit (id),
    sha256 BLOB    NOT NULL CHECK (length(sha256) = 32),
    PRIMARY KEY (tenant, number)
) STRICT, WITHOUT ROWID;

CREATE TABLE audit_seals (
    tenant      TEXT    NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    number      INTEGER NOT NULL CHECK (number >= 1),
    at          TEXT    NOT NULL CHECK (length(at) = 27),
    last_entry  INTEGER NOT NULL CHECK (last_entry >= 1),
    last_sha256 BLOB    NOT NULL CHECK (length(last_sha256) = 32),
    previous    BLOB    NOT NULL CHECK (length(previous) = 32),
    sha256      BLOB    NOT NULL CHECK (length(sha256) = 32),
    signature   BLOB    CHECK (length(signature) = 64),
    public_key  BLOB    CHECK (length(public_key) = 32),
    upto        INTEGER NOT NULL,
    PRIMARY KEY (tenant, number)
) STRICT, WITHOUT ROWID;
CREATE INDEX audit_seals_by_time ON audit_seals (at);

CREATE TABLE table_mappings (
    tenant  TEXT NOT NULL,
    key     BLOB NOT NULL CHECK (length(key) = 32),
    mapping TEXT NOT NULL CHECK (json_valid(mapping)),
    kept_at TEXT NOT NULL CHECK (length(kept_at) = 27),
    PRIMARY KEY (tenant, key)
) STRICT;

CREATE TABLE probe (
    id         INTEGER PRIMARY KEY CHECK (id = 1),
    checked_at TEXT    NOT NULL CHECK (length(checked_at) = 27),
    filler     BLOB
) STRICT;

-- Views

CREATE VIEW measured AS
SELECT i.job AS job, i.number AS number, i.id AS id, i.measured_at AS measured_at, i.instrument AS instrument,
       i.operator AS operator, i.note AS note, i.created_at AS created_at,
       coalesce(r.measurand ->> '$.flank', i.flank) AS flank, coalesce(r.measurand ->> '$.tooth', i.tooth) AS tooth,
       coalesce(r.measurand -> '$.axes', i.axes) AS axes, coalesce(r.measurand ->> '$.accept_units', 0) AS accept_units
FROM iterations i
LEFT JOIN records r ON r.job = i.job AND r.number = i.number AND r.position = (
    SELECT max(m.position) FROM records m WHERE m.job = i.job AND m.number = i.number AND m.kind = 'measurand'
);

CREATE VIEW expected_flanks AS
SELECT f.job AS job, f.flank AS flank, f.tooth AS tooth, f.number AS number, CASE (
    SELECT d.decision FROM decisions d WHERE d.job = f.job AND d.number = f.number ORDER BY d.position DESC LIMIT 1
) WHEN 'rejected' THEN 1 WHEN 'remachine' THEN 2 WHEN 'accepted' THEN 4 ELSE 3 END AS rank
FROM (SELECT m.job AS job, coalesce(m.flank, '') AS flank, coalesce(m.tooth, '') AS tooth, max(m.number) AS number
      FROM measured m GROUP BY 1, 2, 3) AS f;

CREATE VIEW horizon AS
SELECT (SELECT coalesce(max(seq), 0) + 1 FROM sqlite_sequence WHERE name = 'told') AS told,
       (SELECT coalesce(max(changed_by), 0) + 1 FROM audit) AS audit;

-- What must not be changed or deleted

CREATE TRIGGER jobs_keep_their_tenant BEFORE UPDATE OF tenant ON jobs WHEN NEW.tenant <> OLD.tenant
BEGIN
    SELECT RAISE (ABORT, 'a job stays with its tenant');
END;

CREATE TRIGGER iterations_no_update BEFORE UPDATE ON iterations
WHEN NEW.operator NOTNULL OR NEW.note NOTNULL OR NOT EXISTS (SELECT 1 FROM purges WHERE job = OLD.job)
     OR (NEW.job, NEW.number, NEW.id, NEW.measured_at, NEW.instrument, NEW.flank, NEW.tooth, NEW.axes, NEW.created_at)
     IS NOT (OLD.job, OLD.number, OLD.id, OLD.measured_at, OLD.instrument, OLD.flank, OLD.tooth, OLD.axes, OLD.created_at)
BEGIN
    SELECT RAISE (ABORT, 'iterations is append-only');
END;
CREATE TRIGGER iterations_no_delete BEFORE DELETE ON iterations
BEGIN
    SELECT RAISE (ABORT, 'iterations is append-only');
END;

CREATE TRIGGER nodes_no_update BEFORE UPDATE ON nodes
WHEN NEW.data <> x'' OR (NEW.job, NEW.number, NEW.count) IS NOT (OLD.job, OLD.number, OLD.count)
     OR NOT EXISTS (SELECT 1 FROM purges WHERE job = OLD.job)
BEGIN
    SELECT RAISE (ABORT, 'nodes is append-only');
END;
CREATE TRIGGER nodes_no_delete BEFORE DELETE ON nodes
BEGIN
    SELECT RAISE (ABORT, 'nodes is append-only');
END;

CREATE TRIGGER fits_no_update BEFORE UPDATE ON fits
WHEN NEW.reason NOTNULL OR NEW.actor NOTNULL OR NEW.flank_figures NOTNULL OR NEW.spec <> x'' OR NEW.result <> x''
     OR NEW.coefficients NOTNULL OR NEW.prior NOTNULL OR NOT EXISTS (SELECT 1 FROM purges WHERE job = OLD.job)
     OR (NEW.job, NEW.number, NEW.position, NEW.id, NEW.created_at, NEW.lambda_star, NEW.criterion, NEW.scheme, NEW.count,
         NEW.condition, NEW.regularized_condition, NEW.bias_norm, NEW.bias_sharp_bound, NEW.rms, NEW.max_abs)
     IS NOT (OLD.job, OLD.number, OLD.position, OLD.id, OLD.created_at, OLD.lambda_star, OLD.criterion, OLD.scheme, OLD.count,
         OLD.condition, OLD.regularized_condition, OLD.bias_norm, OLD.bias_sharp_bound, OLD.rms, OLD.max_abs)
BEGIN
    SELECT RAISE (ABORT, 'fits is append-only');
END;
CREATE TRIGGER fits_no_delete BEFORE DELETE ON fits
BEGIN
    SELECT RAISE (ABORT, 'fits is append-only');
END;

CREATE TRIGGER fit_choices_no_update BEFORE UPDATE ON fit_choices
WHEN NEW.reason NOTNULL OR NEW.actor NOTNULL OR NOT EXISTS (SELECT 1 FROM purges WHERE job = OLD.job)
     OR (NEW.job, NEW.number, NEW.position, NEW.fit, NEW.created_at)
     IS NOT (OLD.job, OLD.number, OLD.position, OLD.fit, OLD.created_at)
BEGIN
    SELECT RAISE (ABORT, 'fit_choices is append-only');
END;
CREATE TRIGGER fit_choices_no_delete BEFORE DELETE ON fit_choices
BEGIN
    SELECT RAISE (ABORT, 'fit_choices is append-only');
END;

CREATE TRIGGER decisions_no_update BEFORE UPDATE ON decisions
WHEN NEW.reason NOTNULL OR NEW.actor NOTNULL OR NOT EXISTS (SELECT 1 FROM purges WHERE job = OLD.job)
     OR (NEW.job, NEW.number, NEW.position, NEW.decision, NEW.concession, NEW.created_at)
     IS NOT (OLD.job, OLD.number, OLD.position, OLD.decision, OLD.concession, OLD.created_at)
BEGIN
    SELECT RAISE (ABORT, 'decisions is append-only');
END;
CREATE TRIGGER decisions_no_delete BEFORE DELETE ON decisions
BEGIN
    SELECT RAISE (ABORT, 'decisions is append-only');
END;

CREATE TRIGGER records_no_update BEFORE UPDATE ON records
WHEN NEW.request <> x'' OR NEW.result <> x'' OR NEW.gear NOTNULL OR NEW.actor NOTNULL
     OR NOT EXISTS (SELECT 1 FROM purges WHERE job = OLD.job)
     OR (NEW.job, NEW.number, NEW.position, NEW.id, NEW.kind, NEW.method, NEW.class, NEW.measurand, NEW.created_at)
     IS NOT (OLD.job, OLD.number, OLD.position, OLD.id, OLD.kind, OLD.method, OLD.class, OLD.measurand, OLD.created_at)
BEGIN
    SELECT RAISE (ABORT, 'records is append-only');
END;
CREATE TRIGGER records_no_delete BEFORE DELETE ON records
BEGIN
    SELECT RAISE (ABORT, 'records is append-only');
END;

CREATE TRIGGER events_no_update BEFORE UPDATE ON events
BEGIN
    SELECT RAISE (ABORT, 'events is append-only');
END;
-- Only a job that has nothing else takes its events along.
CREATE TRIGGER events_no_delete BEFORE DELETE ON events
WHEN EXISTS (SELECT 1 FROM iterations WHERE job = OLD.job) OR EXISTS (SELECT 1 FROM streams WHERE job = OLD.job)
BEGIN
    SELECT RAISE (ABORT, 'events is append-only');
END;

CREATE TRIGGER purges_no_update BEFORE UPDATE ON purges
BEGIN
    SELECT RAISE (ABORT, 'purges is append-only');
END;
CREATE TRIGGER purges_no_delete BEFORE DELETE ON purges
BEGIN
    SELECT RAISE (ABORT, 'purges is append-only');
END;

CREATE TRIGGER audit_no_update BEFORE UPDATE ON audit
WHEN NEW.actor NOTNULL OR NEW.salt NOTNULL OR NOT EXISTS (SELECT 1 FROM purges WHERE job = OLD.job)
     OR (NEW.changed_by, NEW.id, NEW.tenant, NEW.job, NEW.at, NEW.action, NEW.subject, NEW.request_id, NEW.peer, NEW.contents, NEW.who)
     IS NOT (OLD.changed_by, OLD.id, OLD.tenant, OLD.job, OLD.at, OLD.action, OLD.subject, OLD.request_id, OLD.peer, OLD.contents,
         OLD.who)
BEGIN
    SELECT RAISE (ABORT, 'audit is append-only');
END;
CREATE TRIGGER audit_no_delete BEFORE DELETE ON audit
BEGIN
    SELECT RAISE (ABORT, 'audit is append-only');
END;
CREATE TRIGGER audit_seals_no_update BEFORE UPDATE ON audit_seals
BEGIN
    SELECT RAISE (ABORT, 'audit_seals is append-only');
END;
CREATE TRIGGER audit_seals_no_delete BEFORE DELETE ON audit_seals
BEGIN
    SELECT RAISE (ABORT, 'audit_seals is append-only');
END;
CREATE TRIGGER audit_chain_no_update BEFORE UPDATE ON audit_chain
BEGIN
    SELECT RAISE (ABORT, 'audit_chain is append-only');
END;
CREATE TRIGGER audit_chain_no_delete BEFORE DELETE ON audit_chain
BEGIN
    SELECT RAISE (ABORT, 'audit_chain is append-only');
END;

CREATE TRIGGER api_keys_no_delete BEFORE DELETE ON api_keys
BEGIN
    SELECT RAISE (ABORT, 'keys are kept');
END;
CREATE TRIGGER api_keys_stay_revoked BEFORE UPDATE OF revoked_at ON api_keys
WHEN OLD.revoked_at IS NOT NULL AND NEW.revoked_at IS NOT OLD.revoked_at
BEGIN
    SELECT RAISE (ABORT, 'a revoked key stays revoked');
END;
CREATE TRIGGER api_keys_stay_what_they_are BEFORE UPDATE OF id, tenant, role, scopes, sha256, san, created_at ON api_keys
BEGIN
    SELECT RAISE (ABORT, 'a key stays what it is');
END;
CREATE TRIGGER api_keys_stay_replaced BEFORE UPDATE OF replaced_by, expires_at ON api_keys
WHEN OLD.replaced_by IS NOT NULL
    AND (NEW.replaced_by IS NOT OLD.replaced_by OR NEW.expires_at IS NULL OR NEW.expires_at > OLD.expires_at)
BEGIN
    SELECT RAISE (ABORT, 'a replaced key stays replaced, and its end is not put off');
END;

-- What a purge takes away

CREATE TRIGGER purges_take_away AFTER INSERT ON purges
BEGIN
    UPDATE jobs SET purged_at = NEW.at WHERE id = NEW.job;
    UPDATE iterations SET operator = NULL, note = NULL WHERE job = NEW.job;
    UPDATE nodes SET data = x'' WHERE job = NEW.job;
    UPDATE fits SET reason = NULL, actor = NULL, flank_figures = NULL, spec = x'', result = x'', coefficients = NULL, prior = NULL
    WHERE job = NEW.job;
    UPDATE fit_choices SET reason = NULL, actor = NULL WHERE job = NEW.job;
    UPDATE decisions SET reason = NULL, actor = NULL WHERE job = NEW.job;
    UPDATE records SET request = x'', result = x'', gear = NULL, actor = NULL WHERE job = NEW.job;
    DELETE FROM stream_states WHERE stream IN (SELECT id FROM streams WHERE job = NEW.job);
    DELETE FROM stream_blocks WHERE stream IN (SELECT id FROM streams WHERE job = NEW.job);
    UPDATE streams SET spec = x'' WHERE job = NEW.job;
    -- the entry of the purge itself comes later
    UPDATE audit SET actor = NULL, salt = NULL WHERE job = NEW.job;
END;

-- What the list of jobs is filtered and sorted by

CREATE TRIGGER text_of_new_jobs AFTER INSERT ON jobs
BEGIN
    INSERT INTO jobs_text (rowid, folded) VALUES (NEW.doc, NEW.folded || char(10));
END;
CREATE TRIGGER text_of_jobs AFTER UPDATE OF folded ON jobs WHEN NEW.folded <> OLD.folded
BEGIN
    INSERT INTO jobs_text (jobs_text, rowid, folded) VALUES ('delete', OLD.doc, OLD.folded || char(10));
    INSERT INTO jobs_text (rowid, folded) VALUES (NEW.doc, NEW.folded || char(10));
END;
CREATE TRIGGER text_of_deleted_jobs AFTER DELETE ON jobs
BEGIN
    INSERT INTO jobs_text (jobs_text, rowid, folded) VALUES ('delete', OLD.doc, OLD.folded || char(10));
END;

CREATE TRIGGER change_of_new_jobs AFTER INSERT ON jobs
BEGIN
    UPDATE jobs SET changed_at = NEW.updated_at WHERE id = NEW.id;
END;
CREATE TRIGGER change_of_jobs AFTER UPDATE OF updated_at ON jobs WHEN NEW.updated_at > NEW.changed_at
BEGIN
    UPDATE jobs SET changed_at = NEW.updated_at WHERE id = NEW.id;
END;
-- Who stores many iterations notes them in their jobs once, before they are there; only what was not noted so is noted here.
CREATE TRIGGER change_of_iterations AFTER INSERT ON iterations
WHEN EXISTS (SELECT 1 FROM jobs WHERE id = NEW.job AND (iteration_count < NEW.number OR changed_at < NEW.created_at))
BEGIN
    UPDATE jobs SET iteration_count = max(iteration_count, NEW.number), changed_at = max(changed_at, NEW.created_at)
    WHERE id = NEW.job;
END;
-- The first fit and the first choice are made with their iteration.
CREATE TRIGGER change_of_fits AFTER INSERT ON fits WHEN NEW.position > 1
BEGIN
    UPDATE jobs SET changed_at = NEW.created_at WHERE id = NEW.job AND changed_at < NEW.created_at;
END;
CREATE TRIGGER change_of_choices AFTER INSERT ON fit_choices WHEN NEW.position > 1
BEGIN
    UPDATE jobs SET changed_at = NEW.created_at WHERE id = NEW.job AND changed_at < NEW.created_at;
END;
CREATE TRIGGER change_of_records AFTER INSERT ON records
BEGIN
    UPDATE jobs SET changed_at = NEW.created_at WHERE id = NEW.job AND changed_at < NEW.created_at;
END;
CREATE TRIGGER class_of_jobs AFTER INSERT ON records WHEN NEW.kind = 'evaluation'
BEGIN
    UPDATE jobs SET class = NEW.class WHERE id = NEW.job;
END;
CREATE TRIGGER change_of_decisions AFTER INSERT ON decisions
BEGIN
    UPDATE jobs SET changed_at = NEW.created_at WHERE id = NEW.job AND changed_at < NEW.created_at;
    UPDATE flanks SET rank = CASE NEW.decision WHEN 'rejected' THEN 1 WHEN 'remachine' THEN 2 ELSE 4 END
    WHERE job = NEW.job AND number = NEW.number;
END;

CREATE TRIGGER status_of_new_flanks AFTER INSERT ON flanks
BEGIN
    UPDATE jobs SET status = CASE (SELECT min(rank) FROM flanks WHERE job = NEW.job)
        WHEN 1 THEN 'rejected' WHEN 2 THEN 'remachine' WHEN 3 THEN 'open' ELSE 'accepted' END
    WHERE id = NEW.job;
END;
CREATE TRIGGER status_of_flanks AFTER UPDATE OF rank ON flanks WHEN NEW.rank <> OLD.rank
BEGIN
    UPDATE jobs SET status = CASE (SELECT min(rank) FROM flanks WHERE job = NEW.job)
        WHEN 1 THEN 'rejected' WHEN 2 THEN 'remachine' WHEN 3 THEN 'open' ELSE 'accepted' END
    WHERE id = NEW.job;
END;
CREATE TRIGGER flanks_of_iterations AFTER INSERT ON iterations
BEGIN
    INSERT INTO flanks (job, flank, tooth, number, rank)
    VALUES (NEW.job, coalesce(NEW.flank, ''), coalesce(NEW.tooth, ''), NEW.number, 3)
    ON CONFLICT (job, flank, tooth) DO UPDATE SET number = excluded.number, rank = 3;
END;
-- An iteration that turns out to be of another flank leaves its own to the one before it.
CREATE TRIGGER flanks_of_measurands AFTER INSERT ON records WHEN NEW.kind = 'measurand' AND NEW.method = 'changed'
BEGIN
    DELETE FROM flanks WHERE job = NEW.job;
    INSERT INTO flanks (job, flank, tooth, number, rank)
    SELECT job, flank, tooth, number, rank FROM expected_flanks WHERE job = NEW.job;
END;

-- Events

CREATE TRIGGER events_of_iterations AFTER INSERT ON iterations
BEGIN
    INSERT INTO events (job, number, kind, created_at, iteration)
    SELECT NEW.job, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = NEW.job), 'iteration', NEW.created_at, NEW.number;
END;
CREATE TRIGGER events_of_fits AFTER INSERT ON fits WHEN NEW.position > 1
BEGIN
    INSERT INTO events (job, number, kind, created_at, iteration, fit)
    SELECT NEW.job, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = NEW.job), 'fit', NEW.created_at, NEW.number,
           NEW.position;
END;
CREATE TRIGGER events_of_choices AFTER INSERT ON fit_choices WHEN NEW.position > 1
BEGIN
    INSERT INTO events (job, number, kind, created_at, iteration, fit, position)
    SELECT NEW.job, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = NEW.job), 'fit', NEW.created_at, NEW.number,
           NEW.fit, NEW.position;
END;
CREATE TRIGGER events_of_decisions AFTER INSERT ON decisions
BEGIN
    INSERT INTO events (job, number, kind, created_at, iteration, position)
    SELECT NEW.job, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = NEW.job), 'decision', NEW.created_at, NEW.number,
           NEW.position;
END;
CREATE TRIGGER events_of_records AFTER INSERT ON records
BEGIN
    INSERT INTO events (job, number, kind, created_at, iteration, record)
    SELECT NEW.job, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = NEW.job), 'record', NEW.created_at, NEW.number,
           NEW.id;
END;
CREATE TRIGGER events_of_new_streams AFTER INSERT ON streams
BEGIN
    INSERT INTO events (job, number, kind, created_at, stream, state, sequence, node_count)
    SELECT NEW.job, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = NEW.job), 'stream', NEW.updated_at, NEW.id, 'open',
           NEW.sequence, NEW.node_count;
END;
CREATE TRIGGER events_of_blocks AFTER UPDATE OF sequence ON streams WHEN NEW.sequence > OLD.sequence
BEGIN
    INSERT INTO events (job, number, kind, created_at, stream, state, sequence, node_count)
    SELECT NEW.job, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = NEW.job), 'stream', NEW.updated_at, NEW.id, 'block',
           NEW.sequence, NEW.node_count;
END;
CREATE TRIGGER events_of_finished_streams AFTER UPDATE OF iteration ON streams
WHEN OLD.iteration IS NULL AND NEW.iteration IS NOT NULL
BEGIN
    INSERT INTO events (job, number, kind, created_at, iteration, stream, state, sequence, node_count)
    SELECT NEW.job, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = NEW.job), 'stream', NEW.updated_at, NEW.iteration,
           NEW.id, 'finished', NEW.sequence, NEW.node_count;
END;
-- Whoever deletes a stream first sets its updated_at.
CREATE TRIGGER events_of_deleted_streams AFTER DELETE ON streams
BEGIN
    INSERT INTO events (job, number, kind, created_at, iteration, stream, state, sequence, node_count)
    SELECT OLD.job, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = OLD.job), 'stream', OLD.updated_at, OLD.iteration,
           OLD.id, 'deleted', OLD.sequence, OLD.node_count;
END;
CREATE TRIGGER events_of_purges AFTER INSERT ON purges
BEGIN
    INSERT INTO events (job, number, kind, created_at)
    SELECT NEW.job, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = NEW.job), 'purged', NEW.at;
END;
-- Whoever changes a job writes all of it; triggers and purges name none of these columns.
CREATE TRIGGER events_of_changed_jobs AFTER UPDATE OF name ON jobs
BEGIN
    INSERT INTO events (job, number, kind, created_at)
    SELECT NEW.id, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = NEW.id), 'job', NEW.updated_at;
END;
CREATE TRIGGER events_of_all AFTER INSERT ON events
BEGIN
    INSERT INTO told (tenant, job, number) SELECT tenant, id, NEW.number FROM jobs WHERE id = NEW.job;
END;
CREATE TRIGGER events_of_new_jobs AFTER INSERT ON jobs
BEGIN
    INSERT INTO told (tenant, job, state, created_at) VALUES (NEW.tenant, NEW.id, 'created', NEW.created_at);
END;
