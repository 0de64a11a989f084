"""Run by test_store_kill.py as a program that is killed: writes without end, tells each step."""

from __future__ import annotations

import sys

if __name__ == "__main__":
    import store_samples

    from motiondb import store

    path, what = sys.argv[1:]
    print("opening", flush=True)
    with store.open_store(path) as database:
        print("writing", flush=True)
        for turn in range(10_000):
            if what == "add":
                store_samples.add(database, f"{turn}/take", n_frames=40)
            elif what == "batch":
                with store.transaction(database):
                    for number in range(4):
                        store_samples.add(database, f"{turn}/{number}", n_frames=40)
            elif what == "remove":
                store_samples.add(database, f"{turn}/take")
                store.remove_captures(database, [turn + 1])
            elif what == "grammar":
                infos = store.load_captures(database)
                with store.transaction(database):
                    run_id = store.start_run(database, "grammar", seed=turn)
                    learned = store_samples.grammar("dance", infos, objective=float(turn))
                    store.save_grammar(database, learned, run_id)
                    store.finish_run(database, run_id)
            else:
                infos = store.load_captures(database)
                run_id = store.start_run(database, "learn", seed=turn)
                learning = store_samples.learning(infos, run_id, n_symbols=40, seed=turn)
                store.save_learning(database, learning)
            print(turn, flush=True)
