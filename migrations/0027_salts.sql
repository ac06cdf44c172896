-- Entries of jobs have a salt in their contents: a byte 5, `_salt`, 32 bytes, before all else. With the name of who made an entry a purge
-- takes it away, so that nobody can try names against the digests that stay.
DROP TRIGGER audit_no_update;
CREATE TRIGGER audit_no_update BEFORE UPDATE ON audit
WHEN NEW.actor <> '' OR NOT EXISTS (SELECT 1 FROM jobs j JOIN purges p ON p.job = j.seq WHERE j.id = OLD.chain)
     OR (NEW.seq, NEW.tenant, NEW.chain, NEW.number, NEW.id, NEW.at, NEW.action, NEW.target, NEW.request_id, NEW.peer, NEW.outcome,
         NEW.previous, NEW.sha256)
     IS NOT (OLD.seq, OLD.tenant, OLD.chain, OLD.number, OLD.id, OLD.at, OLD.action, OLD.target, OLD.request_id, OLD.peer, OLD.outcome,
         OLD.previous, OLD.sha256)
     OR (NEW.contents IS NOT OLD.contents
         AND NEW.contents IS NOT CASE WHEN substr(OLD.contents, 1, 6) = x'055F73616C74' THEN substr(OLD.contents, 39) END)
BEGIN
    SELECT RAISE (ABORT, 'audit is append-only');
END;
