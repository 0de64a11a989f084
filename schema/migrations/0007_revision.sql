-- The number that every committed change raises.
INSERT INTO meta VALUES ('revision', '0');
