-- Scenes: several characters, made by a motion grammar from a tactics diagram.
CREATE TABLE scene (
    scene_id BIGINT PRIMARY KEY,
    name VARCHAR NOT NULL UNIQUE,
    diagram VARCHAR NOT NULL,
    grammar VARCHAR NOT NULL,
    settings VARCHAR NOT NULL,
    error DOUBLE NOT NULL,
    report VARCHAR NOT NULL,
    n_frames BIGINT NOT NULL CHECK (n_frames > 0),
    run_id BIGINT NOT NULL REFERENCES run (run_id)
);
CREATE TABLE scene_player (
    scene_id BIGINT NOT NULL,
    ordinal BIGINT NOT NULL,
    name VARCHAR NOT NULL,
    team VARCHAR NOT NULL,
    rules BIGINT[] NOT NULL,
    x DOUBLE NOT NULL,
    z DOUBLE NOT NULL,
    heading DOUBLE NOT NULL,
    delay BIGINT NOT NULL CHECK (delay >= 0),
    capture_id BIGINT NOT NULL,
    run_id BIGINT NOT NULL,
    PRIMARY KEY (scene_id, ordinal),
    UNIQUE (scene_id, name)
);
CREATE TABLE scene_clip (
    scene_id BIGINT NOT NULL,
    player BIGINT NOT NULL,
    ordinal BIGINT NOT NULL,
    terminal VARCHAR NOT NULL,
    source_name VARCHAR NOT NULL,
    source_sha256 VARCHAR NOT NULL,
    start_frame BIGINT NOT NULL,
    end_frame BIGINT NOT NULL,
    mirrored BOOLEAN NOT NULL,
    bend DOUBLE NOT NULL,
    stretch DOUBLE NOT NULL,
    begin_frame BIGINT NOT NULL,
    run_id BIGINT NOT NULL,
    PRIMARY KEY (scene_id, player, ordinal)
);
CREATE TABLE scene_rule (
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
CREATE TABLE scene_ball (
    scene_id BIGINT NOT NULL,
    frame BIGINT NOT NULL,
    x DOUBLE NOT NULL,
    y DOUBLE NOT NULL,
    z DOUBLE NOT NULL,
    run_id BIGINT NOT NULL
);
