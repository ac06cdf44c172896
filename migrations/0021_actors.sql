-- Who did it: the actor of the caller, where one is known. Rows from before have none.
ALTER TABLE fits ADD COLUMN actor TEXT;
ALTER TABLE fit_choices ADD COLUMN actor TEXT;
ALTER TABLE decisions ADD COLUMN actor TEXT;
ALTER TABLE records ADD COLUMN actor TEXT;

-- A purge takes them away.
DROP TRIGGER fit_choices_no_update;
CREATE TRIGGER fit_choices_no_update BEFORE UPDATE ON fit_choices
WHEN NEW.reason NOTNULL OR NEW.actor NOTNULL
     OR (NEW.iteration, NEW.position, NEW.fit, NEW.created_at) IS NOT (OLD.iteration, OLD.position, OLD.fit, OLD.created_at)
     OR NOT EXISTS (SELECT 1 FROM iterations i JOIN purges p ON p.job = i.job WHERE i.seq = OLD.iteration)
BEGIN
    SELECT RAISE (ABORT, 'fit_choices is append-only');
END;

DROP TRIGGER decisions_no_update;
CREATE TRIGGER decisions_no_update BEFORE UPDATE ON decisions
WHEN NEW.reason NOTNULL OR NEW.actor NOTNULL
     OR (NEW.iteration, NEW.position, NEW.decision, NEW.created_at) IS NOT (OLD.iteration, OLD.position, OLD.decision, OLD.created_at)
     OR NOT EXISTS (SELECT 1 FROM iterations i JOIN purges p ON p.job = i.job WHERE i.seq = OLD.iteration)
BEGIN
    SELECT RAISE (ABORT, 'decisions is append-only');
END;
