-- Entries of jobs have a salt in their contents: a byte 5, `_salt`, 32 bytes, before all else. With the name of who made an entry a purge
-- takes it away, so that nobody can try names against the digests that stay.
CREATE FUNCTION without_salt(contents bytea) RETURNS bytea LANGUAGE sql IMMUTABLE AS $$
    SELECT CASE WHEN substring(contents FROM 1 FOR 6) = '\x055f73616c74' THEN substring(contents FROM 39) ELSE contents END
$$;

CREATE OR REPLACE FUNCTION refuse_all_but_purge() RETURNS trigger LANGUAGE plpgsql AS $$
DECLARE
    of uuid;
BEGIN
    IF TG_TABLE_NAME = 'audit' THEN
        of := OLD.chain;
        IF NEW.contents = without_salt(OLD.contents) THEN
            OLD.contents := NEW.contents;
        END IF;
    ELSE
        of := OLD.job;
    END IF;
    IF NEW *<> jsonb_populate_record(OLD, TG_ARGV[0]::jsonb) OR NOT EXISTS (SELECT FROM purges WHERE job = of) THEN
        RAISE EXCEPTION '% is append-only', TG_TABLE_NAME USING ERRCODE = 'restrict_violation';
    END IF;
    RETURN NEW;
END
$$;

CREATE OR REPLACE FUNCTION take_away(of uuid) RETURNS void LANGUAGE sql SECURITY DEFINER SET search_path FROM CURRENT AS $$
    UPDATE iterations SET operator = NULL, note = NULL WHERE job = of;
    UPDATE nodes SET data = '' WHERE job = of;
    UPDATE fits SET reason = NULL, actor = NULL, flank_figures = NULL, spec = '', result = '', coefficients = NULL, prior = NULL
    WHERE job = of;
    UPDATE fit_choices SET reason = NULL, actor = NULL WHERE job = of;
    UPDATE decisions SET reason = NULL, actor = NULL WHERE job = of;
    UPDATE records SET request = '', result = '', gear = NULL, actor = NULL WHERE job = of;
    UPDATE audit SET actor = '', contents = without_salt(contents) WHERE chain = of;
$$;
