-- Tenants, each a plant. id is a UUIDv7: tenants in order of id are tenants in order of creation. Jobs name their tenant themselves.
CREATE TABLE tenants (
    name        text        PRIMARY KEY CHECK (length(name) BETWEEN 1 AND 63),
    id          uuid        NOT NULL UNIQUE,
    description text,
    suspended   boolean     NOT NULL,
    version     bigint      NOT NULL CHECK (version >= 1),
    created_at  timestamptz NOT NULL,
    updated_at  timestamptz NOT NULL
);

-- The tenant of callers that no tenant is known of.
INSERT INTO tenants (name, id, suspended, version, created_at, updated_at)
VALUES ('default', '00000000-0000-0000-0000-000000000000', false, 1, '2026-11-23T00:00:00Z', '2026-11-23T00:00:00Z');

-- Keys: of a secret its digest, of a certificate its name (san). id is 16 hexadecimal digits, compared byte by byte; scopes are names
-- with spaces between them. A key stays for good: what has ended is revoked_at or expires_at. The tenant of keys of no tenant is '@root'.
CREATE TABLE api_keys (
    id           text COLLATE "C" PRIMARY KEY CHECK (length(id) = 16),
    tenant       text        NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    name         text        NOT NULL,
    role         text        CHECK (role IN ('reader', 'operator', 'engineer', 'auditor', 'admin', 'root')),
    scopes       text        NOT NULL,
    sha256       bytea       CHECK (octet_length(sha256) = 32),
    san          text,
    version      bigint      NOT NULL CHECK (version >= 1),
    created_at   timestamptz NOT NULL,
    expires_at   timestamptz,
    last_used_at timestamptz,
    revoked_at   timestamptz,
    CHECK ((sha256 IS NULL) <> (san IS NULL))
);
CREATE INDEX api_keys_of_tenant ON api_keys (tenant, created_at, id);
CREATE INDEX api_keys_by_san ON api_keys (san) WHERE san IS NOT NULL;
-- Who comes with a certificate is one caller.
CREATE UNIQUE INDEX api_keys_one_for_each_san ON api_keys (san) WHERE san IS NOT NULL AND revoked_at IS NULL;

CREATE FUNCTION refuse_loss_of_keys() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    RAISE EXCEPTION 'keys are kept' USING ERRCODE = 'restrict_violation';
END
$$;
CREATE TRIGGER api_keys_no_delete BEFORE DELETE OR TRUNCATE ON api_keys FOR EACH STATEMENT EXECUTE FUNCTION refuse_loss_of_keys();

CREATE FUNCTION refuse_revival() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    RAISE EXCEPTION 'a revoked key stays revoked' USING ERRCODE = 'restrict_violation';
END
$$;
CREATE TRIGGER api_keys_stay_revoked BEFORE UPDATE OF revoked_at ON api_keys FOR EACH ROW
WHEN (OLD.revoked_at IS NOT NULL AND NEW.revoked_at IS DISTINCT FROM OLD.revoked_at) EXECUTE FUNCTION refuse_revival();

CREATE FUNCTION refuse_another_key() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    RAISE EXCEPTION 'a key stays what it is' USING ERRCODE = 'restrict_violation';
END
$$;
CREATE TRIGGER api_keys_stay_what_they_are BEFORE UPDATE OF id, tenant, role, scopes, sha256, san, created_at ON api_keys
FOR EACH ROW EXECUTE FUNCTION refuse_another_key();
