-- Who changed what: one entry for each change, in the transaction of the change. The entries of a chain (that of a job has its id; that of
-- a tenant, of what is of no job, an id made of its name) are numbered 1, 2, 3 …, and each holds the digest of the one before it.
-- contents: of each row that the change wrote, one byte for the length of its name, the name, and its SHA-256.
-- A job may be deleted, and its row's number given again; its entries stay, so they name its id.
CREATE TABLE audit (
    seq        INTEGER PRIMARY KEY,
    tenant     TEXT    NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    chain      BLOB    NOT NULL CHECK (length(chain) = 16),
    number     INTEGER NOT NULL CHECK (number >= 1),
    id         BLOB    NOT NULL CHECK (length(id) = 16),
    at         TEXT    NOT NULL CHECK (length(at) = 27),
    actor      TEXT    NOT NULL,
    action     TEXT    NOT NULL,
    target     TEXT    NOT NULL,
    request_id TEXT,
    peer       TEXT,
    contents   BLOB    NOT NULL,
    outcome    TEXT    NOT NULL,
    previous   BLOB    NOT NULL CHECK (length(previous) = 32),
    sha256     BLOB    NOT NULL CHECK (length(sha256) = 32),
    UNIQUE (chain, number)
) STRICT;

CREATE TRIGGER audit_no_update BEFORE UPDATE ON audit
BEGIN
    SELECT RAISE (ABORT, 'audit is append-only');
END;

CREATE TRIGGER audit_no_delete BEFORE DELETE ON audit
BEGIN
    SELECT RAISE (ABORT, 'audit is append-only');
END;

-- Seals: one for each tenant whose chains grew since the last, over the heads of these. upto: the last row of audit that was looked at.
CREATE TABLE audit_seals (
    tenant     TEXT    NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    number     INTEGER NOT NULL CHECK (number >= 1),
    at         TEXT    NOT NULL CHECK (length(at) = 27),
    heads      INTEGER NOT NULL CHECK (heads >= 1),
    root       BLOB    NOT NULL CHECK (length(root) = 32),
    previous   BLOB    NOT NULL CHECK (length(previous) = 32),
    sha256     BLOB    NOT NULL CHECK (length(sha256) = 32),
    signature  BLOB    CHECK (length(signature) = 64),
    public_key BLOB    CHECK (length(public_key) = 32),
    upto       INTEGER NOT NULL,
    PRIMARY KEY (tenant, number)
) STRICT, WITHOUT ROWID;

-- The heads of a seal: the leaves of its tree, in the order of the chains' keys.
CREATE TABLE audit_sealed (
    tenant TEXT    NOT NULL,
    seal   INTEGER NOT NULL,
    chain  BLOB    NOT NULL CHECK (length(chain) = 16),
    number INTEGER NOT NULL CHECK (number >= 1),
    sha256 BLOB    NOT NULL CHECK (length(sha256) = 32),
    PRIMARY KEY (tenant, seal, chain),
    FOREIGN KEY (tenant, seal) REFERENCES audit_seals (tenant, number)
) STRICT, WITHOUT ROWID;

CREATE INDEX audit_sealed_of_chain ON audit_sealed (chain);

CREATE TRIGGER audit_seals_no_update BEFORE UPDATE ON audit_seals
BEGIN
    SELECT RAISE (ABORT, 'audit_seals is append-only');
END;

CREATE TRIGGER audit_seals_no_delete BEFORE DELETE ON audit_seals
BEGIN
    SELECT RAISE (ABORT, 'audit_seals is append-only');
END;

CREATE TRIGGER audit_sealed_no_update BEFORE UPDATE ON audit_sealed
BEGIN
    SELECT RAISE (ABORT, 'audit_sealed is append-only');
END;

CREATE TRIGGER audit_sealed_no_delete BEFORE DELETE ON audit_sealed
BEGIN
    SELECT RAISE (ABORT, 'audit_sealed is append-only');
END;
