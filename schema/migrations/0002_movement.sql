-- How every segment moves, apart from symbols (search/movement.py).
CREATE TABLE segment_movement (
    ordinal BIGINT NOT NULL,
    movement FLOAT[] NOT NULL,
    run_id BIGINT NOT NULL
);
