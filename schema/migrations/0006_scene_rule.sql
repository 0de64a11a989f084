-- Migration 0005 was edited after databases had used it: these have a table scene_rule without the
-- columns about and unit. Here it is built anew with all its columns; in other databases nothing
-- changes. What was not kept is empty.
CREATE TABLE scene_rule_0006 (
    scene_id BIGINT NOT NULL,
    ordinal BIGINT NOT NULL,
    player VARCHAR NOT NULL,
    action VARCHAR NOT NULL,
    clip BIGINT NOT NULL,
    kind VARCHAR NOT NULL,
    about VARCHAR NOT NULL,
    unit VARCHAR NOT NULL,
    before DOUBLE NOT NULL,
    after DOUBLE NOT NULL,
    threshold DOUBLE NOT NULL,
    frame BIGINT NOT NULL,
    kept BOOLEAN NOT NULL,
    run_id BIGINT NOT NULL,
    PRIMARY KEY (scene_id, ordinal)
);
ALTER TABLE scene_rule ADD COLUMN IF NOT EXISTS about VARCHAR;
ALTER TABLE scene_rule ADD COLUMN IF NOT EXISTS unit VARCHAR;
INSERT INTO scene_rule_0006 BY NAME
    SELECT * REPLACE (coalesce(about, '') AS about, coalesce(unit, '') AS unit) FROM scene_rule;
DROP TABLE scene_rule;
ALTER TABLE scene_rule_0006 RENAME TO scene_rule;
