"""What fabrics do beyond a strain-energy law, one effect a file: each a term that is absent at its null value.

A measured curve is built in this order: slack of the grips and permanent set change the stretch, the law (with
directions, contraction and added terms) gives the stress, temperature scales it, damage, friction and viscosity
depend on how it came about, and the load cell adds its offset.
"""
