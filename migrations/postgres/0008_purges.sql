-- Jobs whose nodes, results, texts and names were taken away, with why, and with the digest of the archive that has them. What the trace may
-- lose it loses only beside such a row, and only so: the row that stays has its numbers and its times.
CREATE TABLE purges (
    job            uuid        PRIMARY KEY REFERENCES jobs (id),
    at             timestamptz NOT NULL,
    reason         text        NOT NULL,
    archive_sha256 bytea       NOT NULL CHECK (octet_length(archive_sha256) = 32)
);
CREATE TRIGGER purges_append_only BEFORE UPDATE OR DELETE OR TRUNCATE ON purges
FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();

-- The time of the purge once more, where every write looks.
ALTER TABLE jobs ADD COLUMN purged_at timestamptz;

CREATE FUNCTION note_purge() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    UPDATE jobs SET purged_at = NEW.at WHERE id = NEW.job;
    RETURN NULL;
END
$$;
CREATE TRIGGER purges_of_jobs AFTER INSERT ON purges FOR EACH ROW EXECUTE FUNCTION note_purge();

-- What is due: jobs that nobody has touched for long.
CREATE INDEX jobs_to_purge ON jobs (changed_at) WHERE purged_at IS NULL;

-- Refuses to change a row, but to take away what the argument names, of a purged job. Images are compared, so that −0.0 is not 0.0.
CREATE FUNCTION refuse_all_but_purge() RETURNS trigger LANGUAGE plpgsql AS $$
DECLARE
    of uuid;
BEGIN
    IF TG_TABLE_NAME = 'audit' THEN
        of := OLD.chain;
    ELSE
        of := OLD.job;
    END IF;
    IF NEW *<> jsonb_populate_record(OLD, TG_ARGV[0]::jsonb) OR NOT EXISTS (SELECT FROM purges WHERE job = of) THEN
        RAISE EXCEPTION '% is append-only', TG_TABLE_NAME USING ERRCODE = 'restrict_violation';
    END IF;
    RETURN NEW;
END
$$;

DROP TRIGGER iterations_append_only ON iterations;
CREATE TRIGGER iterations_append_only BEFORE DELETE OR TRUNCATE ON iterations FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER iterations_not_changed BEFORE UPDATE ON iterations FOR EACH ROW
EXECUTE FUNCTION refuse_all_but_purge('{"operator": null, "note": null}');

DROP TRIGGER nodes_append_only ON nodes;
CREATE TRIGGER nodes_append_only BEFORE DELETE OR TRUNCATE ON nodes FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER nodes_not_changed BEFORE UPDATE ON nodes FOR EACH ROW EXECUTE FUNCTION refuse_all_but_purge('{"data": ""}');

DROP TRIGGER fits_append_only ON fits;
CREATE TRIGGER fits_append_only BEFORE DELETE OR TRUNCATE ON fits FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER fits_not_changed BEFORE UPDATE ON fits FOR EACH ROW
EXECUTE FUNCTION refuse_all_but_purge('{"reason": null, "spec": "", "result": "", "coefficients": null, "prior": null}');

DROP TRIGGER fit_choices_append_only ON fit_choices;
CREATE TRIGGER fit_choices_append_only BEFORE DELETE OR TRUNCATE ON fit_choices FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER fit_choices_not_changed BEFORE UPDATE ON fit_choices FOR EACH ROW EXECUTE FUNCTION refuse_all_but_purge('{"reason": null}');

DROP TRIGGER decisions_append_only ON decisions;
CREATE TRIGGER decisions_append_only BEFORE DELETE OR TRUNCATE ON decisions FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER decisions_not_changed BEFORE UPDATE ON decisions FOR EACH ROW EXECUTE FUNCTION refuse_all_but_purge('{"reason": null}');

DROP TRIGGER records_append_only ON records;
CREATE TRIGGER records_append_only BEFORE DELETE OR TRUNCATE ON records FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER records_not_changed BEFORE UPDATE ON records FOR EACH ROW
EXECUTE FUNCTION refuse_all_but_purge('{"request": "", "result": "", "gear": null}');

-- Of an entry the name of who made it goes; sha256 still tells it.
DROP TRIGGER audit_append_only ON audit;
CREATE TRIGGER audit_append_only BEFORE DELETE OR TRUNCATE ON audit FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER audit_not_changed BEFORE UPDATE ON audit FOR EACH ROW EXECUTE FUNCTION refuse_all_but_purge('{"actor": ""}');

-- Takes away what a purged job has of the trace: with the rights of the owner, so that the service needs none to change it.
CREATE FUNCTION take_away(of uuid) RETURNS void LANGUAGE sql SECURITY DEFINER SET search_path FROM CURRENT AS $$
    UPDATE iterations SET operator = NULL, note = NULL WHERE job = of;
    UPDATE nodes SET data = '' WHERE job = of;
    UPDATE fits SET reason = NULL, spec = '', result = '', coefficients = NULL, prior = NULL WHERE job = of;
    UPDATE fit_choices SET reason = NULL WHERE job = of;
    UPDATE decisions SET reason = NULL WHERE job = of;
    UPDATE records SET request = '', result = '', gear = NULL WHERE job = of;
    UPDATE audit SET actor = '' WHERE chain = of;
$$;
REVOKE ALL ON FUNCTION take_away(uuid) FROM PUBLIC;
