package ssv.spy;

import java.awt.Dimension;
import javax.swing.Action;
import javax.swing.JDesktopPane;
import lcm.spy.ChannelData;
import lcm.spy.SpyPlugin;
import ssv.planner_status_t;

/** For lcm-spy: a double click on SSV_PLANNER_STATUS shows what each planner does in a second. */
public final class StatusPlugin implements SpyPlugin {
    @Override
    public boolean canHandle(long fingerprint) {
        return fingerprint == planner_status_t.LCM_FINGERPRINT;
    }

    @Override
    public Action getAction(JDesktopPane pane, ChannelData channel) {
        return new Window<>("Rates of the planners", planner_status_t.class, StatusView::new, new Dimension(720, 760), pane, channel);
    }
}
