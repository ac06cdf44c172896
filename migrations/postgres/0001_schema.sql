-- Everything in one schema. Keys begin with the job, then the number of the iteration, then the position of a thing within it, each
-- 1, 2, 3 … without gaps: what was stored last has the greatest position. Whoever writes locks the row of the job first.
--
-- Documents (spec, request, result, …) are bytea: their text in UTF-8, or where it is longer than 8 kB a frame of zstd, whose first
-- bytes (28 B5 2F FD) no text begins with. They are answered again byte for byte, so jsonb is not for them.

-- Transactions that changed something, by an id that the writer gave: one that lost the answer to its COMMIT looks here.
CREATE TABLE commits (
    id uuid        PRIMARY KEY,
    at timestamptz NOT NULL DEFAULT now()
);

-- The last migration that a program must know to work on this schema. Later migrations only add, until one raises this.
CREATE TABLE schema_floor (
    one       boolean PRIMARY KEY DEFAULT true CHECK (one),
    migration bigint  NOT NULL
);
INSERT INTO schema_floor (migration) VALUES (1);

CREATE TABLE jobs (
    id            uuid        PRIMARY KEY,
    tenant        text        NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    name          text        NOT NULL,
    part_number   text,
    serial_number text,
    machine       text,
    gear          text,
    tags          text        NOT NULL,
    version       bigint      NOT NULL CHECK (version >= 1),
    created_at    timestamptz NOT NULL,
    updated_at    timestamptz NOT NULL
);
CREATE INDEX jobs_of_tenant ON jobs (tenant, id);

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

-- The nodes as posted, in a compact binary form whose first byte tells its version.
CREATE TABLE nodes (
    job    uuid   NOT NULL,
    number bigint NOT NULL,
    count  bigint NOT NULL CHECK (count >= 0),
    data   bytea  NOT NULL,
    PRIMARY KEY (job, number),
    FOREIGN KEY (job, number) REFERENCES iterations (job, number)
);
ALTER TABLE nodes ALTER COLUMN data SET STORAGE EXTERNAL;

-- spec: the fit request without its nodes; result: the answer. coefficients and prior are those of the result once more, so that the
-- trace, which tells them, reads no results. A figure that does not exist is NULL.
CREATE TABLE fits (
    job                   uuid        NOT NULL,
    number                bigint      NOT NULL,
    position              bigint      NOT NULL CHECK (position >= 1),
    id                    uuid        NOT NULL,
    reason                text,
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
    spec                  bytea       NOT NULL,
    result                bytea       NOT NULL,
    coefficients          bytea,
    prior                 bytea,
    PRIMARY KEY (job, number, position),
    UNIQUE (job, number, id),
    FOREIGN KEY (job, number) REFERENCES iterations (job, number)
);

-- Which fit stands: the choice with the greatest position. fit is the position of a fit of the same iteration.
CREATE TABLE fit_choices (
    job        uuid        NOT NULL,
    number     bigint      NOT NULL,
    position   bigint      NOT NULL CHECK (position >= 1),
    fit        bigint      NOT NULL,
    reason     text,
    created_at timestamptz NOT NULL,
    PRIMARY KEY (job, number, position),
    FOREIGN KEY (job, number, fit) REFERENCES fits (job, number, position)
);

-- What was decided: the decision with the greatest position holds.
CREATE TABLE decisions (
    job        uuid        NOT NULL,
    number     bigint      NOT NULL,
    position   bigint      NOT NULL CHECK (position >= 1),
    decision   text        NOT NULL CHECK (decision IN ('accept', 'remachine', 'reject')),
    reason     text,
    created_at timestamptz NOT NULL,
    PRIMARY KEY (job, number, position),
    FOREIGN KEY (job, number) REFERENCES iterations (job, number)
);

-- Whatever is kept with an iteration beside its fits; gear is that of the job when the record was made.
CREATE TABLE records (
    job        uuid        NOT NULL,
    number     bigint      NOT NULL,
    position   bigint      NOT NULL CHECK (position >= 1),
    id         uuid        NOT NULL,
    kind       text        NOT NULL CHECK (kind IN ('curve', 'surface', 'deviations', 'evaluation', 'correction')),
    method     text        NOT NULL,
    created_at timestamptz NOT NULL,
    request    bytea       NOT NULL,
    result     bytea       NOT NULL,
    gear       text,
    PRIMARY KEY (job, number, position),
    UNIQUE (job, number, id),
    FOREIGN KEY (job, number) REFERENCES iterations (job, number)
);

-- Streams: nodes that arrive while the probe is still moving. iteration is set when the stream has become one. input_sha256 is a chain
-- over spec and blocks.
CREATE TABLE streams (
    id                uuid        PRIMARY KEY,
    job               uuid        NOT NULL REFERENCES jobs (id),
    spec              bytea       NOT NULL,
    forgetting_factor float8      NOT NULL CHECK (forgetting_factor > 0 AND forgetting_factor <= 1),
    sequence          bigint      NOT NULL CHECK (sequence >= 0),
    node_count        bigint      NOT NULL CHECK (node_count >= 0),
    input_sha256      bytea       NOT NULL CHECK (octet_length(input_sha256) = 32),
    flank             text        CHECK (flank IN ('left', 'right')),
    tooth             text,
    axes              text,
    iteration         bigint,
    version           bigint      NOT NULL CHECK (version >= 1),
    created_at        timestamptz NOT NULL,
    updated_at        timestamptz NOT NULL,
    FOREIGN KEY (job, iteration) REFERENCES iterations (job, number)
);
CREATE INDEX streams_of_job ON streams (job);

-- Blocks of nodes as posted (the form of table nodes), until the stream is finished; then its iteration holds them.
CREATE TABLE stream_blocks (
    stream     uuid        NOT NULL REFERENCES streams (id),
    sequence   bigint      NOT NULL CHECK (sequence >= 1),
    sha256     bytea       NOT NULL CHECK (octet_length(sha256) = 32),
    count      bigint      NOT NULL CHECK (count >= 1),
    data       bytea       NOT NULL,
    created_at timestamptz NOT NULL,
    PRIMARY KEY (stream, sequence)
);
ALTER TABLE stream_blocks ALTER COLUMN data SET STORAGE EXTERNAL;

-- The estimate's numbers after a block, so that an open stream goes on without reading every node again.
CREATE TABLE stream_states (
    stream   uuid   PRIMARY KEY REFERENCES streams (id),
    sequence bigint NOT NULL CHECK (sequence >= 1),
    data     bytea  NOT NULL
);
ALTER TABLE stream_states ALTER COLUMN data SET STORAGE EXTERNAL;

-- What happened to a job, numbered 1, 2, 3 … within it. Rows are written by triggers, hence in the transaction of the thing itself,
-- whoever writes it. They name what happened (fit, position: within the iteration; stream, state, …: of a stream, which may be deleted
-- later); the rest is read from the thing.
CREATE TABLE events (
    job        uuid        NOT NULL REFERENCES jobs (id),
    number     bigint      NOT NULL CHECK (number >= 1),
    kind       text        NOT NULL CHECK (kind IN ('iteration', 'fit', 'decision', 'stream')),
    iteration  bigint,
    fit        bigint,
    position   bigint,
    stream     uuid,
    state      text        CHECK (state IN ('open', 'block', 'finished', 'deleted')),
    sequence   bigint,
    node_count bigint,
    created_at timestamptz NOT NULL,
    PRIMARY KEY (job, number)
);

-- Answers kept for clients that ask again with the same Idempotency-Key; scope is method and path. A row without an answer is a claim:
-- it is given one, or deleted, before its transaction ends. Where an answer has the result of a fit in it, the fit is named, body is
-- what stands before the result, and body_end what stands after it.
CREATE TABLE idempotency_keys (
    tenant         text        NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    key            text        NOT NULL,
    scope          text        NOT NULL,
    request_sha256 bytea       CHECK (octet_length(request_sha256) = 32),
    status         bigint,
    location       text,
    etag           text,
    body           bytea,
    job            uuid,
    number         bigint,
    fit            bigint,
    body_end       bytea,
    created_at     timestamptz NOT NULL DEFAULT now(),
    PRIMARY KEY (tenant, key, scope),
    FOREIGN KEY (job, number, fit) REFERENCES fits (job, number, position),
    CHECK (num_nonnulls(request_sha256, status, body) IN (0, 3)),
    CHECK (num_nonnulls(job, number, fit, body_end) IN (0, 4))
);
CREATE INDEX idempotency_keys_by_age ON idempotency_keys (created_at);

-- One row that is written to find out whether the database can be written to.
CREATE TABLE probe (
    id         bigint      PRIMARY KEY CHECK (id = 1),
    checked_at timestamptz NOT NULL
);
