"""The constants of `unwrap`: its progress, rounds of cutting, and what counts as few or as a line."""

# Share of the whole that is told when each part of the work ends. Other shares only make the bar less even.
PROGRESS = {"seams": 0.3, "charts": 0.95, "packing": 1.0}

# -- Seams

# L2 stretch that seams must save, beyond their price, on a component that needs none. Less cuts nearly flat
# pieces; more leaves disks stretched. benchmarks/constants.py charts.constants.
DISK_GAIN = 0.05

# Rounds of splitting in which a chart gets more seams: to tips, against flips, for less stretch. Then it is
# bisected. Fewer make straight cuts; more take time. tests/surface/repair/test_cleaning.py
SEAM_ROUNDS = 8

# Times that `trade` is doubled until seams are found for such a chart. Fewer bisect charts that a branch
# would mend; more search where there is none. tests/surface/repair/test_cleaning.py.
TRADE_DOUBLINGS = 12

# -- Charts

# Area over squared extent up to which a map is taken for a line, and bisected. Less leaves charts that no
# packing can turn; more bisects thin strips. tests/surface/repair/test_slivers.py.
NEEDLE_AREA = 1e-13

# Triangles of the smallest pieces, in all, that are flattened together although pieces are few. Less flattens
# them one by one; more gains nothing, as large ones share no work. benchmarks/many.py.
FEW_TRIANGLES = 4_000

# -- Pages

# Share of a page that the margins around all charts may take. More leaves charts no room; less makes margins
# smaller than asked for where they would do. tests/charts/packing/test_packing.py.
MARGIN_SHARE = 0.64

# Fill of a page above which many charts are not cut further: they lie in each other's gaps. Less leaves
# pages emptier; more takes time for cuts that do not pay. benchmarks/unwrap.py prints the fill.
FULL_PAGE = 0.57

# Share of a trial's page below which a search among more places hardly comes. Less packs charts in vain;
# more cuts charts that fill a page uncut. benchmarks/constants.py charts.constants prints fill and charts.
LEAST_PAGE = 0.88
