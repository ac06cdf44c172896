-- The newest seal of any tenant says how far the audit is sealed.
CREATE INDEX audit_seals_by_time ON audit_seals (at);
