"""Files, pictures and news of a run; knows no kinds of scenes.

Read `atomic.py` (how files are replaced), the recorders of the time loop (`recorder`, `history`,
`iterations`, `vtk`, `checkpoint`, `run_record`), `seals.py` (how damage to them is seen before a
run goes on), `step_records.py` (the same for runs without time), `forecast.py`, and what pictures
share (`figures`, `flow_slice`).
"""
