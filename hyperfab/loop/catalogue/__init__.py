"""What a model may lack, one module a domain and one function an entry, scaled to the data in the domain's context.

``entries(context)`` of a domain are all, by name; ``not_sought`` says why where one has no meaning for the
model or the data.
"""

from __future__ import annotations

from hyperfab.loop.problem import Constant, Form, tried_if


def softening(span: float, temperatures: int) -> list[Form]:
    """Return stiffness exponential in temperature over a ``span`` [K]; of three ``temperatures`` also its curvature."""
    linear = Constant("softening_1_K", 0.0, -5.0 / span, 5.0 / span, 0.1 / span)
    forms = [Form("exponential", (linear,), ((0.2 / span,), (-0.2 / span,)), ((0.02 / span,),))]
    bend = Constant("softening_1_K2", 0.0, -5.0 / span**2, 5.0 / span**2, 0.1 / span**2)
    curved = Form("curved", (linear, bend), ((0.2 / span, 0.05 / span**2),), refines="exponential")
    return forms + tried_if(temperatures > 2, curved)
