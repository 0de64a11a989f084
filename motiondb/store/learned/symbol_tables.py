"""Tables of the motion symbols and of the symbol space."""

from __future__ import annotations

import numpy as np

from motiondb.records import MotionSymbols, SymbolSpace
from motiondb.store.connection.columns import fetch, from_rows, insert, to_rows
from motiondb.store.connection.statements import Connection

TABLES = ("symbol", "symbol_state", "symbol_distance", "space_stress", "cluster")


def insert_symbols(
    connection: Connection, symbols: MotionSymbols, space: SymbolSpace, run_id: int
) -> None:
    """Write the symbols with their places; padding is left out."""
    numbers = np.arange(symbols.n_symbols)
    insert(
        connection,
        "symbol",
        symbol_id=numbers,
        n_states=symbols.n_states,
        cluster_id=space.clusters,
        coordinates=to_rows(space.coordinates),
        run_id=np.full(len(numbers), run_id),
    )
    ids, states = np.nonzero(np.arange(symbols.means.shape[1]) < symbols.n_states[:, None])
    insert(
        connection,
        "symbol_state",
        symbol_id=ids,
        state=states,
        self_loop=symbols.self_loops[ids, states],
        means=to_rows(symbols.means[ids, states]),
        covars=to_rows(symbols.covars[ids, states]),
        run_id=np.full(len(ids), run_id),
    )


def select_symbols(connection: Connection, max_states: int, n_features: int) -> MotionSymbols:
    """Read the symbols, padded as they were."""
    n_states = fetch(connection, "SELECT n_states FROM symbol ORDER BY symbol_id")["n_states"]
    rows = fetch(
        connection,
        "SELECT symbol_id, state, self_loop, means, covars FROM symbol_state",
    )
    place = (rows["symbol_id"], rows["state"])
    self_loops = np.zeros((len(n_states), max_states))
    means = np.zeros((len(n_states), max_states, n_features))
    covars = np.ones_like(means)
    self_loops[place] = rows["self_loop"]
    means[place] = from_rows(rows["means"], (n_features,))
    covars[place] = from_rows(rows["covars"], (n_features,))
    return MotionSymbols(n_states, self_loops, means, covars)


def insert_space(connection: Connection, space: SymbolSpace, run_id: int) -> None:
    """Write distances, stress and clusters (coordinates are in the table ``symbol``)."""
    n = len(space.distances)
    ids, others = np.divmod(np.arange(n * n), max(n, 1))
    insert(
        connection,
        "symbol_distance",
        symbol_id=ids,
        other_id=others,
        distance=space.distances.ravel(),
        variance=space.variances.ravel(),
        run_id=np.full(n * n, run_id),
    )
    insert(
        connection,
        "space_stress",
        dimensions=np.arange(1, len(space.stress) + 1),
        stress=space.stress,
        run_id=np.full(len(space.stress), run_id),
    )
    insert(
        connection,
        "cluster",
        cluster_id=np.arange(len(space.weights)),
        weight=space.weights,
        mean=to_rows(space.means),
        covar=to_rows(space.covars),
        run_id=np.full(len(space.weights), run_id),
    )


def select_space(connection: Connection, dimensions: int) -> SymbolSpace:
    """Read the symbol space of ``dimensions`` dimensions."""
    places = fetch(connection, "SELECT cluster_id, coordinates FROM symbol ORDER BY symbol_id")
    pairs = fetch(
        connection, "SELECT distance, variance FROM symbol_distance ORDER BY symbol_id, other_id"
    )
    clusters = fetch(connection, "SELECT weight, mean, covar FROM cluster ORDER BY cluster_id")
    n = len(places["cluster_id"])
    return SymbolSpace(
        distances=pairs["distance"].reshape(n, n),
        variances=pairs["variance"].reshape(n, n),
        coordinates=from_rows(places["coordinates"], (dimensions,)),
        stress=fetch(connection, "SELECT stress FROM space_stress ORDER BY dimensions")["stress"],
        clusters=places["cluster_id"],
        weights=clusters["weight"],
        means=from_rows(clusters["mean"], (dimensions,)),
        covars=from_rows(clusters["covar"], (dimensions, dimensions)),
    )
