-- Who changed what: one entry for each change, in the transaction of the change. The entries of a chain (that of a job has its id; that of
-- a tenant, of what is of no job, an id made of its name) are numbered 1, 2, 3 …, and each holds the digest of the one before it.
-- contents: of each row that the change wrote, one byte for the length of its name, the name, and its SHA-256.
-- A job may be deleted; its entries stay. changed_by: the transaction, by whose number seals are told what is new.
CREATE TABLE audit (
    tenant     text        NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    chain      uuid        NOT NULL,
    number     bigint      NOT NULL CHECK (number >= 1),
    id         uuid        NOT NULL,
    at         timestamptz NOT NULL,
    actor      text        NOT NULL,
    action     text        NOT NULL,
    target     text        NOT NULL,
    request_id text,
    peer       text,
    contents   bytea       NOT NULL,
    outcome    text        NOT NULL,
    previous   bytea       NOT NULL CHECK (octet_length(previous) = 32),
    sha256     bytea       NOT NULL CHECK (octet_length(sha256) = 32),
    changed_by bigint      NOT NULL DEFAULT (pg_current_xact_id()::text::bigint),
    PRIMARY KEY (chain, number)
);
-- small, because the numbers of transactions ascend with the rows
CREATE INDEX audit_by_transaction ON audit USING brin (changed_by);

-- Seals: one for each tenant whose chains grew since the last, over the heads of these. upto: the transaction before which all were ended
-- that it looked at.
CREATE TABLE audit_seals (
    tenant     text        NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    number     bigint      NOT NULL CHECK (number >= 1),
    at         timestamptz NOT NULL,
    heads      bigint      NOT NULL CHECK (heads >= 1),
    root       bytea       NOT NULL CHECK (octet_length(root) = 32),
    previous   bytea       NOT NULL CHECK (octet_length(previous) = 32),
    sha256     bytea       NOT NULL CHECK (octet_length(sha256) = 32),
    signature  bytea       CHECK (octet_length(signature) = 64),
    public_key bytea       CHECK (octet_length(public_key) = 32),
    upto       bigint      NOT NULL,
    PRIMARY KEY (tenant, number)
);

-- The heads of a seal: the leaves of its tree, in the order of the chains' keys.
CREATE TABLE audit_sealed (
    tenant text   NOT NULL,
    seal   bigint NOT NULL,
    chain  uuid   NOT NULL,
    number bigint NOT NULL CHECK (number >= 1),
    sha256 bytea  NOT NULL CHECK (octet_length(sha256) = 32),
    PRIMARY KEY (tenant, seal, chain),
    FOREIGN KEY (tenant, seal) REFERENCES audit_seals (tenant, number)
);
CREATE INDEX audit_sealed_of_chain ON audit_sealed (chain);

CREATE TRIGGER audit_append_only BEFORE UPDATE OR DELETE OR TRUNCATE ON audit
FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER audit_seals_append_only BEFORE UPDATE OR DELETE OR TRUNCATE ON audit_seals
FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER audit_sealed_append_only BEFORE UPDATE OR DELETE OR TRUNCATE ON audit_sealed
FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();

-- An entry tells of its transaction from now on, and whoever writes without one must not write here.
DROP TABLE commits;
UPDATE schema_floor SET migration = 4;
