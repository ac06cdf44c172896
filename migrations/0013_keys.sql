-- Tenants, each a plant. id is a UUIDv7: tenants in order of id are tenants in order of creation. Jobs name their tenant themselves.
CREATE TABLE tenants (
    name        TEXT    PRIMARY KEY CHECK (length(name) BETWEEN 1 AND 63),
    id          BLOB    NOT NULL UNIQUE CHECK (length(id) = 16),
    description TEXT,
    suspended   INTEGER NOT NULL CHECK (suspended IN (0, 1)),
    version     INTEGER NOT NULL CHECK (version >= 1),
    created_at  TEXT    NOT NULL CHECK (length(created_at) = 27),
    updated_at  TEXT    NOT NULL CHECK (length(updated_at) = 27)
) STRICT, WITHOUT ROWID;

-- The tenant of callers that no tenant is known of, and of jobs from before there were any.
INSERT INTO tenants (name, id, suspended, version, created_at, updated_at)
VALUES ('default', zeroblob(16), 0, 1, '2026-11-23T00:00:00.000000Z', '2026-11-23T00:00:00.000000Z');

-- Keys: of a secret its digest, of a certificate its name (san). id is 16 hexadecimal digits; scopes are names with spaces between them. A
-- key stays for good: what has ended is revoked_at or expires_at. The tenant of keys of no tenant is '@root'.
CREATE TABLE api_keys (
    id           TEXT    PRIMARY KEY CHECK (length(id) = 16),
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
    CHECK ((sha256 IS NULL) <> (san IS NULL))
) STRICT, WITHOUT ROWID;

CREATE INDEX api_keys_of_tenant ON api_keys (tenant, created_at, id);

CREATE INDEX api_keys_by_san ON api_keys (san) WHERE san IS NOT NULL;

-- Who comes with a certificate is one caller.
CREATE UNIQUE INDEX api_keys_one_for_each_san ON api_keys (san) WHERE san IS NOT NULL AND revoked_at IS NULL;

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
