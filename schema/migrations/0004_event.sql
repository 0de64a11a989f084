-- Instants of captures: feet that strike, balls that are caught and released, contacts.
CREATE TABLE event (
    capture_id BIGINT NOT NULL,
    frame BIGINT NOT NULL CHECK (frame >= 0),
    name VARCHAR NOT NULL,
    joint VARCHAR NOT NULL,
    other VARCHAR NOT NULL,
    PRIMARY KEY (capture_id, frame, name, joint, other)
);
