package ssv.spy;

import java.awt.Dimension;
import javax.swing.Action;
import javax.swing.JDesktopPane;
import lcm.spy.ChannelData;
import lcm.spy.SpyPlugin;
import ssv.plan_t;

/** For lcm-spy: a double click on SSV_PLAN shows thrust curves and the way from above. */
public final class PlanPlugin implements SpyPlugin {
    @Override
    public boolean canHandle(long fingerprint) {
        return fingerprint == plan_t.LCM_FINGERPRINT;
    }

    @Override
    public Action getAction(JDesktopPane pane, ChannelData channel) {
        return new Window<>("Thrusts and way of the plan", plan_t.class, PlanView::new, new Dimension(1100, 700), pane, channel);
    }
}
