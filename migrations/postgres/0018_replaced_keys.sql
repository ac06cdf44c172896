-- Which key took the place of another: that one is not rotated once more, and its end is not put off. Keys that were rotated before have
-- none, since a key's digest in the audit has it.
ALTER TABLE api_keys ADD COLUMN replaced_by text COLLATE "C" REFERENCES api_keys (id);

CREATE FUNCTION refuse_another_successor() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    RAISE EXCEPTION 'a replaced key stays replaced, and its end is not put off' USING ERRCODE = 'restrict_violation';
END
$$;
CREATE TRIGGER api_keys_stay_replaced BEFORE UPDATE OF replaced_by, expires_at ON api_keys FOR EACH ROW
WHEN (OLD.replaced_by IS NOT NULL
    AND (NEW.replaced_by IS DISTINCT FROM OLD.replaced_by OR NEW.expires_at IS NULL OR NEW.expires_at > OLD.expires_at)) EXECUTE FUNCTION refuse_another_successor();
